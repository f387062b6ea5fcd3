"""The command line: `flexmb COMMAND`."""

from flexmb.cli.command_line import main
