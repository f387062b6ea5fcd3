"""The command line: `flexmb COMMAND`.

In: words typed in a shell. Out: files, tables, an exit status. A command: an entry of `arguments/index.py`, a function.
"""

from flexmb.cli.command_line import main as main
