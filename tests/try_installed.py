"""First mechanism of an installation: it runs, and compiles nothing; for `make try-wheel`.

With `--compiles` an installation may compile, as one without shipped code does.
"""

import sys
import time
from pathlib import Path
from typing import Any

import flexmb as fm
from flexmb.version import versions

HERE = Path(__file__).resolve().parents[1]


def compiled_functions() -> list[str]:
    """Names of the functions that numba compiles from now on, in a list that grows."""
    from numba.core import event

    names: list[str] = []

    class Names(event.Listener):  # type: ignore[misc, name-defined]
        def on_start(self, found: Any) -> None:
            names.append(found.data["dispatcher"].py_func.__qualname__)

        def on_end(self, found: Any) -> None: ...

    event.register("numba:compile", Names())
    return names


def main() -> str:
    """What is wrong with the installation, or nothing."""
    if HERE in Path(fm.__file__).resolve().parents and "site-packages" not in fm.__file__:
        return f"{fm.__file__} is the checkout, not an installation"
    compiled, began = compiled_functions(), time.perf_counter()
    sol = fm.simulate(fm.mechanisms.slider_crank(clearance=5e-4), t_end=0.01)
    print(f"{versions()}\n{sol.status} {time.perf_counter() - began:.1f} s, {len(compiled)} functions compiled")
    if not sol.ok:
        return "the first mechanism did not run"
    if compiled and "--compiles" not in sys.argv:
        return f"compiled: {', '.join(compiled)}"
    return ""


if __name__ == "__main__":
    sys.exit(main() or 0)
