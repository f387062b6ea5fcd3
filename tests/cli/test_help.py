"""Help pages end with examples that can be parsed; completion knows all commands; faults end without traceback."""

import fcntl
import os
import pty
import re
import shlex
import shutil
import struct
import subprocess
import sys
import termios

import pytest

from flexmb.cli.arguments.index import COMMANDS
from flexmb.cli.arguments.parser import parser_of, source_of
from flexmb.cli.command_line import explained, main
from flexmb.dynamics.jobs import progress

EXAMPLES = [(command, line) for command in COMMANDS for line in command.examples]


def help_of(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        main([*arguments, "--help"])
    assert stop.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.name)
def test_every_help_ends_with_its_examples(command, capsys):
    text = help_of([command.name], capsys)
    assert 2 <= len(command.examples) <= 3
    assert text.endswith("examples:\n" + "".join(f"  {line}\n" for line in command.examples))


@pytest.mark.parametrize(("command", "line"), EXAMPLES, ids=[line for _, line in EXAMPLES])
def test_every_example_is_understood(command, line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "press"]) == 0  # some examples begin with its file
    typed = re.search(r"flexmb ([^|>)]*)", line)[1]
    given = shlex.split(typed.strip('" '))
    source = source_of(given)
    parser, _ = parser_of(source, given[0])
    assert parser.parse_args(given).command == given[0]


def test_the_main_help_lists_all_commands_in_order_and_exit_statuses(capsys):
    text = help_of([], capsys)
    places = [text.index(f"\n    {command.name} ") if len(command.name) < 9 else text.index(f"\n    {command.name}\n")
              for command in COMMANDS]  # fmt: skip
    assert places == sorted(places)
    assert re.findall(r"^  (\d+) ", text, re.MULTILINE) == ["0", "1", "2", "3", "130"]


@pytest.mark.parametrize("command", [c.name for c in COMMANDS])
def test_every_command_has_its_function(command):
    from importlib import import_module

    module, function = next(c for c in COMMANDS if c.name == command).place
    assert callable(vars(import_module(module))[function])


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_scripts(shell, capsys, tmp_path):
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(re.search(rf"\b{command.name}\b", script) for command in COMMANDS)
    assert "clearance" in script
    if shutil.which(shell):
        path = tmp_path / "script"
        path.write_text(script)
        assert subprocess.run([shell, "-n", str(path)], capture_output=True, check=False).stderr == b""


@pytest.mark.skipif(not shutil.which("bash"), reason="without bash")
@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("flexmb che", ["check"]),
        ("flexmb run slider", ["slider-crank"]),
        ("flexmb run mod", ["model.py"]),
        ("flexmb run slider-crank --cl", ["--clearance"]),
        ("flexmb check nine-bar --js", ["--json"]),
        ("flexmb completion z", ["zsh"]),
        ("flexmb vtk r", ["run.nc"]),
        ("flexmb vtk run.nc --cl", []),
    ],
)
def test_bash_completes(typed, offered, tmp_path, capsys):
    (tmp_path / "model.py").touch()
    (tmp_path / "run.nc").touch()
    assert main(["completion", "bash"]) == 0
    words = typed.split()
    ask = f'COMP_WORDS=({" ".join(words)}); COMP_CWORD={len(words) - 1}; _flexmb; echo "${{COMPREPLY[*]}}"'
    command = ["bash", "--norc", "-c", capsys.readouterr().out + ask]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.stderr == ""
    assert done.stdout.split() == offered


@pytest.mark.parametrize(
    ("error", "code", "text"),
    [
        (PermissionError(13, "Permission denied", "/x/y"), 2, "/x/y: Permission denied"),
        (MemoryError(), 2, "not enough memory"),
        (ModuleNotFoundError("no", name="lxml.etree"), 2, "pip install lxml"),
        (TypeError("three"), 3, "TypeError: three. That should not happen"),
    ],
)
def test_errors_in_one_line(error, code, text):
    found, told = explained(error)
    assert found == code
    assert text in told


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("x = 1 / 0", "model.py, line 2: ZeroDivisionError: division by zero"),
        ("fm.RigidBody('b', (0, 0), mass=-1, inertia=1)", "model.py, line 2: RigidBody 'b': mass is -1 kg"),
        ("def mech():\n    return fm.Mechanism('x', [foo])", "model.py, line 3: NameError: name 'foo' is not defined"),
        ("import notthere", "the package 'notthere' is missing"),
    ],
)
def test_an_error_in_a_model_file_names_its_line(line, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.py").write_text(f"import flexmb as fm\n{line}\n")
    assert main(["check", "model.py"]) == 2
    out, err = capsys.readouterr()
    assert message in err
    assert "Traceback" not in err
    assert out == ""


def test_a_fault_without_traceback_and_with_it(monkeypatch, capsys):
    def fails(options):
        raise RuntimeError("three")

    monkeypatch.setattr("flexmb.cli.arguments.parser.list_mechanisms", fails)
    assert main(["list"]) == 3
    assert capsys.readouterr().err.startswith("flexmb: RuntimeError: three")
    with pytest.raises(RuntimeError):
        main(["list", "--debug"])


def test_progress_in_a_file_is_a_few_whole_lines(monkeypatch, capsys):
    clock = iter(range(0, 100000, 10))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(clock)))
    with progress.ProgressBar("run", 2.0, shown=True, of="s of motion") as bar:
        for _ in range(20):
            bar.update(0.1)
    err = capsys.readouterr().err
    assert "\r" not in err
    lines = err.splitlines()
    assert 2 <= len(lines) <= 6
    assert all(re.match(r"run: \d+ %, .* of 2 s of motion, ", line) for line in lines)
    assert lines[-1].startswith("run: 100 %, 2 of 2 s of motion")


def test_a_sweep_has_points_enough_for_the_word_chaotic_by_default():
    """Without an exponent `judge` needs 100 points; the command kept 50."""
    from flexmb.dynamics.verdict import LEAST_APERIODIC

    given = ["sweep", "slider-crank", "--speed", "150:200:2"]
    parser, _ = parser_of(source_of(given), "sweep")
    assert parser.parse_args(given).keep == LEAST_APERIODIC == 100


def test_progress_on_a_terminal_is_a_bar():
    code = (
        "from flexmb.dynamics.jobs.progress import ProgressBar\n"
        "with ProgressBar('run', 2.0, shown=True, of='s of motion') as bar:\n    bar.update(2.0)"
    )
    here, there = pty.openpty()
    fcntl.ioctl(there, termios.TIOCSWINSZ, struct.pack("HHHH", 25, 100, 0, 0))
    with subprocess.Popen([sys.executable, "-c", code], stderr=there, stdout=subprocess.DEVNULL) as run:
        os.close(there)
        shown = b""
        try:
            while piece := os.read(here, 4096):
                shown += piece
        except OSError:  # the other end is closed
            pass
    os.close(here)
    assert run.returncode == 0
    assert b"100%" in shown
    assert b"\r" in shown
