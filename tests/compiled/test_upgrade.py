"""Files of the package that change under a living process, as by an upgrade: none of its machine code is kept."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import flexmb
from flexmb import namespace
from flexmb.engine.compiled import code_cache

FILE = "flexmb/parts/drives/motions.py"
CALL = """import sys
from pathlib import Path
import numpy as np
import flexmb
from flexmb.parts.drives.motions import constant_speed_kernel
for name in sys.argv[1:]:
    file = Path(name)
    file.write_text(file.read_text().replace("return w * t, w, 0.0", "return w * t, 7.0 * w, 0.0"))
p = np.array([3.0])
p.flags.writeable = False
print(constant_speed_kernel.dispatcher(p, 2.0)[1])
"""


@pytest.fixture
def call(tmp_path):
    """A function (further words) that calls a kernel of a copy of the package in a new process: its two outputs."""
    copy = tmp_path / "flexmb"
    shutil.copytree(Path(flexmb.__file__).parent, copy, ignore=shutil.ignore_patterns("__pycache__", "shipped"))
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    environment |= {"FLEXMB_MESSAGES": "1"}

    def run(*words):
        found = subprocess.run(
            [sys.executable, "-c", CALL, *words],
            check=False,
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
        )
        return found.stdout.strip(), found.stderr

    return run


SAID = "compiled code is neither read nor kept: files of flexmb have changed since it was imported"


def test_code_of_old_sources_is_not_kept_under_the_new_ones(call, tmp_path):
    """The next process took the old law's machine code for that of the new one."""
    value, said = call(str(tmp_path / FILE))
    assert value == "3.0"
    assert said.count(SAID) == 1
    assert call()[0] == "21.0"


@pytest.mark.slow
def test_unchanged_files_keep_their_code(call, tmp_path):
    value, said = call()
    assert (value, SAID in said) == ("3.0", False)
    kept = {file: file.read_bytes() for file in (tmp_path / "cache").rglob("*.nb?")}
    assert kept
    assert call() == ("3.0", "")
    assert {file: file.read_bytes() for file in (tmp_path / "cache").rglob("*.nb?")} == kept


def test_code_of_a_new_installation_is_not_read_by_an_old_process(monkeypatch, tmp_path):
    """An index that fits the new files said nothing about the functions of this process."""
    code_cache.Shipment("x86-64-v3").write(tmp_path)
    assert code_cache.Shipped(tmp_path)
    monkeypatch.setitem(namespace.IMPORTED, next(iter(namespace.IMPORTED)), (0, 0, 0))
    with pytest.raises(ValueError, match="start Python anew"):
        code_cache.Shipped(tmp_path)
