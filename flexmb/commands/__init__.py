"""What the commands of the command line do; `flexmb.cli` reads the arguments."""
