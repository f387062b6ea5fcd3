"""The command line: `flexmb COMMAND`.

In: words typed in a shell. Out: files, tables, an exit status. A command is an entry of `arguments/index.py` and a
function.
"""

from flexmb.cli.command_line import main as main
