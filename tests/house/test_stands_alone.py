"""The repository stands alone: nothing in it names a machine, a host, a neighbouring folder or a workplace."""

import shutil
import subprocess
from pathlib import Path

import pytest

LINE_END = b"\n"

# Written in two parts each, so that this file does not contain what it looks for.
NEIGHBOUR = "../sha" + "red"
HOSTS = [
    "pypi" + ".org",
    "python" + "hosted",
    "ana" + "conda.org",
    "npm" + "js.org",
    "debian" + ".org",
]
MACHINE = ["/wo" + "rk/", "/ro" + "ot/"]
ORGANISATION = ["farm" + "-bench", "iss" + "ues show", "sub" + "agent", "before" + "-stop"]


def files_of(root: Path) -> list[Path]:
    """Files that git tracks, and new ones that it does not ignore."""
    command = ["git", "-C", str(root), "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    listed = subprocess.run(command, check=True, capture_output=True).stdout.decode().split("\0")
    return [root / name for name in listed if name and (root / name).is_file()]


def forbidden_in(name: str, content: bytes) -> list[str]:
    """'file:line: word' for each forbidden word. Tests may compare with a neighbouring folder where there is one."""
    words = [*HOSTS, *MACHINE, *ORGANISATION]
    if not name.startswith("tests/"):
        words.append(NEIGHBOUR)
    text = content.lower()
    hits = [(text.find(word.encode()), word) for word in words]
    return [f"{name}:{text.count(LINE_END, 0, at) + 1}: {word}" for at, word in hits if at >= 0]


@pytest.fixture(scope="module")
def files(root) -> list[Path]:
    if shutil.which("git") is None or not (root / ".git").exists():
        pytest.skip("not a git checkout: nothing says which files are ours")
    return files_of(root)


def test_no_file_names_its_surroundings(root, files):
    found = []
    for file in files:
        found += forbidden_in(file.relative_to(root).as_posix(), file.read_bytes())
    assert not found, "\n".join(found)


def test_the_listing_sees_this_file(files):
    assert Path(__file__).resolve() in files


@pytest.mark.parametrize("word", [NEIGHBOUR, *HOSTS, *MACHINE, *ORGANISATION])
def test_each_word_is_found(word):
    assert forbidden_in("docs/some.md", f"first line\nsee {word} here".encode()) == [f"docs/some.md:2: {word}"]


def test_case_does_not_hide_a_word():
    assert forbidden_in("README.md", HOSTS[0].upper().encode()) == [f"README.md:1: {HOSTS[0]}"]


def test_tests_may_compare_with_a_neighbour():
    assert forbidden_in("tests/some.py", NEIGHBOUR.encode()) == []
