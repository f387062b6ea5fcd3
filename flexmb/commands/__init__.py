"""Commands of the command line; `flexmb.cli` reads their arguments."""
