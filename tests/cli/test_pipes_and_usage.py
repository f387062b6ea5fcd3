"""A reader that closes its pipe, and options that a command has not."""

import os
import subprocess
import sys

import pytest

from flexmb.cli.command_line import main


def test_a_reader_that_has_enough(root):
    """`flexmb list | head -1`: no traceback and no error."""
    code = "import sys; from flexmb.cli import main; sys.exit(main(['list']))"
    read, write = os.pipe()
    with subprocess.Popen([sys.executable, "-c", code], cwd=root, stdout=write, stderr=subprocess.PIPE) as run:
        os.close(write)
        os.close(read)
        said = run.stderr.read().decode()
    assert said == ""
    assert run.returncode == 0


@pytest.mark.parametrize("command", [["run", "four-bar"], ["sweep", "four-bar"], ["check", "four-bar"], ["list"]])
def test_an_unknown_option_shows_the_usage_of_its_command(command, capsys):
    with pytest.raises(SystemExit) as stop:
        main([*command, "--bogus", "3"])
    assert stop.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith(f"usage: flexmb {command[0]} ")
    assert said.splitlines()[-1].startswith("--bogus: ")
    assert "Options: --help" in said.splitlines()[-1]
