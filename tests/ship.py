"""Compile for a portable processor what an installation shall bring along: `python tests/ship.py FOLDER`.

FOLDER then holds an index and a file of machine code (`engine/compiled/code_cache.py`); `make wheel` packs them.
Compiled is what is called by all kernels of the package, by a mechanism with each of its parts, and by short runs that
use every loop.  Without FOLDER the same is compiled for this machine, into the cache of the user.  With `--list` the
names of functions are printed; with `--wheel DIST` a wheel that carries them is built.
"""

import argparse
import gc
import os
import pkgutil
import platform
import runpy
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]

PORTABLE_PROCESSORS = {"x86_64": "x86-64-v3"}
"""Generic processor for which code is made, for each architecture; others compile for themselves."""


def main() -> int:
    """Compile in this process, which has not imported numba yet, and write the folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--wheel", type=Path)
    parser.add_argument("--parts", action="store_true", help="compile kernels and parts alone, for this machine")
    options = parser.parse_args()
    sys.path.insert(0, str(ROOT))
    if options.folder is None:
        gc.disable()  # a tenth of the time would be spent on looking through what stays
        compile_parts() if options.parts else compile_here()
        gc.freeze()  # or it would be looked through at the end
        return 0
    cpu = PORTABLE_PROCESSORS.get(platform.machine())
    if cpu is None:
        print(f"No code is shipped for {platform.machine()}: it is compiled where it runs.", file=sys.stderr)
        return 0
    os.environ.update(NUMBA_CPU_NAME=cpu, NUMBA_CPU_FEATURES="", NUMBA_DISABLE_INTEL_SVML="1", FLEXMB_MESSAGES="0")
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as cache:
        os.environ["NUMBA_CACHE_DIR"] = cache
        names, size = ship(cpu, options.folder)
    if options.list:
        print("\n".join(names))
    took = time.perf_counter() - began
    print(f"{len(names)} functions for {cpu}, {size / 1e6:.1f} MB, in {took:.0f} s: {options.folder}")
    if options.wheel is not None:
        pack(options.folder, options.wheel)
    return 0


def pack(folder: Path, target: Path) -> None:
    """Build a wheel with the compiled code of `folder`, one for this version of Python, in `target`."""
    number = f"cp{sys.version_info.major}{sys.version_info.minor}"
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        python("pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", work, str(ROOT))
        pure = next(Path(work).glob("*.whl"))
        python("wheel", "unpack", "--dest", work, str(pure))
        tree = next(path for path in Path(work).iterdir() if path.is_dir())
        shutil.copytree(folder, tree / "flexmb" / "engine" / "compiled" / "shipped", dirs_exist_ok=True)
        python("wheel", "pack", "--dest-dir", str(target), str(tree))
    tags = ("--python-tag", number, "--abi-tag", number, "--platform-tag", platforms())
    python("wheel", "tags", "--remove", *tags, str(target / pure.name))


def platforms() -> str:
    """Platforms of llvmlite's wheel, since the code needs what llvmlite needs; this one if it came otherwise."""
    lines = (distribution("llvmlite").read_text("WHEEL") or "").splitlines()
    known = sorted({line.rpartition("-")[2] for line in lines if line.startswith("Tag: ")})
    return ".".join(known) or sysconfig.get_platform().replace("-", "_").replace(".", "_")


def python(*arguments: str) -> None:
    """Run a module of this Python."""
    subprocess.run([sys.executable, "-m", *arguments], check=True, stdout=subprocess.DEVNULL)


def ship(cpu: str, folder: Path) -> tuple[list[str], int]:
    """Compile everything and write it; names of the functions, and bytes."""
    from flexmb.engine.compiled.code_cache import Shipment, shipment

    shipment.append(Shipment(cpu))
    compile_all()
    return shipment.pop().write(folder)


def compile_all() -> None:
    """Compile all kernels, parts and loops."""
    compile_parts()
    compile_loops()


def compile_here() -> None:
    """Compile all for this machine: loops here, kernels and parts in another process, which shares the cache.

    A piece of code is lowered once in each process that compiles with it, so loops stay together, and so do kernels and
    the helpers of kernels.  Loops come before the runs, whose kernels the other process has compiled then.
    """
    from flexmb.engine.compiled import ahead
    from flexmb.engine.dormand_prince.method import advance_dormand_prince
    from flexmb.engine.newmark.method import advance
    from flexmb.engine.radau.method import advance_radau
    from flexmb.engine.step.runge_kutta import advance_explicit

    loops = advance, advance_radau, advance_dormand_prince, advance_explicit
    ahead.asked.update(f"{one.__module__}.{one.__qualname__}" for one in loops)  # no process for each
    with subprocess.Popen([sys.executable, __file__, "--parts"]) as second:
        for one in loops:
            one.compile(ahead.argument_types(one.py_func))
        compile_loops()
    if second.returncode:
        sys.exit("Kernels and parts could not be compiled; see above.")


def compile_loops() -> None:
    """Compile the loops, by short runs."""
    for run in runs():
        run()


def compile_parts() -> None:
    """Compile every kernel of the package, and what Python calls of it for each built-in part."""
    import flexmb as fm

    for kernel in kernels():
        _ = kernel.address
    parts = runpy.run_path(str(ROOT / "tests" / "parts" / "test_check_part.py"))["BUILT_IN"]
    for mechanism, _ in parts.values():
        fm.compile(mechanism)


def kernels() -> Iterator[Any]:
    """Every kernel of the package."""
    import flexmb
    from flexmb.kernels import Kernel

    for module in pkgutil.walk_packages(flexmb.__path__, "flexmb."):
        if not module.name.endswith("__main__"):
            for found in vars(import_module(module.name)).values():
                yield from (one for one in (found if isinstance(found, tuple) else [found]) if isinstance(one, Kernel))


def runs() -> list[Callable[[], Any]]:
    """Short runs that call every compiled function of a run that Python calls."""
    import flexmb as fm

    ideal, crank = fm.mechanisms.slider_crank(), fm.mechanisms.slider_crank(clearance=5e-4)
    worn = fm.mechanisms.nine_bar(clearance=5e-4, flexible=True)
    rod = runpy.run_path(str(ROOT / "examples" / "spin_up.py"))["spinning_beam"]()
    lugre = fm.mechanisms.slider_crank(clearance=5e-4, friction=fm.friction.LuGre(static=0.12, kinetic=0.1))
    short = {"t_end": 1e-5, "step": 1e-6}
    return [
        lambda: fm.simulate(worn, t_end=1e-5),
        lambda: carry(lugre),
        lambda: fm.simulate(crank, t_end=1e-4),
        lambda: fm.simulate(ideal, **short, method=fm.RungeKutta4()),
        lambda: fm.simulate(crank, t_end=1e-4, method=fm.RadauIIA()),
        lambda: fm.simulate(ideal, t_end=1e-4, method=fm.DormandPrince()),
        own_equation,
        lambda: fm.static_equilibrium(rod),
        lambda: fm.modes(rod),
        lambda: fm.buckling(strut()),
    ]


def strut() -> Any:
    """A clamped beam under a load along it."""
    import flexmb as fm

    beam = fm.FlexibleLink("beam", (0, 0), (1, 0), section=fm.Circle(0.01), material=fm.STEEL)
    foot, load = fm.Fixed("foot", fm.GROUND, beam, (0, 0)), fm.Force("load", beam, (1, 0), (-1.0, 0.0))
    return fm.Mechanism("strut", [beam, foot, load])


def own_equation() -> None:
    """Move a state by a compiled function of a user."""
    import numba

    import flexmb as fm

    fm.chaos.ODE(numba.njit(lambda t, x: (-x[0],)), [1.0]).advance(0.1)


def carry(mechanism: Any) -> None:
    """Carry a difference along a short motion."""
    import flexmb as fm

    flow = fm.chaos.MechanismFlow(mechanism)
    flow.advance(1e-5, flow.tangent_basis(1, seed=0))


if __name__ == "__main__":
    sys.exit(main())
