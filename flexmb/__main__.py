"""`python -m flexmb` is `flexmb`."""

import sys

from flexmb.cli.command_line import main

if __name__ == "__main__":
    sys.exit(main())
