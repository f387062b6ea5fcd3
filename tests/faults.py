"""Faults seeded one at a time into a copy of the package, and whether tests of their room find them.

    python tests/faults.py [--only NUMBER ...]

Each fault is a line that is replaced: a sign, a factor or an index; ten in the core, ten in planes, reduction, cams,
controllers and loads.  `make test` runs the named tests, too, so what they find it finds.  Exit status 1: a fault that
no test found, or a line that is no longer there.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]


class Fault(NamedTuple):
    """A line of the package, what replaces it, and the files of tests that should find it."""

    file: str
    line: str
    wrong: str
    tests: str


CORE = (
    Fault(
        "engine/newmark/predictor.py",
        "trial.v[i] = flow.v[i] + h * ((1.0 - gamma) * x0 + gamma * x1)",
        "trial.v[i] = flow.v[i] + h * (gamma * x0 + (1.0 - gamma) * x1)",
        "physics/test_order.py physics/test_conservation.py",
    ),
    Fault(
        "engine/system/contacts.py",
        "entry = S[places.NORMAL, i] * along + S[places.TANGENTIAL, i] * across + kq * (N * g[i] + T * s[i])",
        "entry = S[places.NORMAL, i] * along + S[places.TANGENTIAL, i] * across + kq * (N * g[i] - T * s[i])",
        "system/test_contact_tangent.py",
    ),
    Fault(
        "engine/system/contacts.py",
        "S[places.TANGENTIAL, 3], S[places.TANGENTIAL, 4], S[places.TANGENTIAL, 5] = -ny, nx, nx * bx + ny * by",
        "S[places.TANGENTIAL, 3], S[places.TANGENTIAL, 4], S[places.TANGENTIAL, 5] = -ny, nx, nx * bx - ny * by",
        "system/test_contact_tangent.py physics/test_imperfect_impacts.py",
    ),
    Fault(
        "engine/energy.py",
        "(trial.mean_v[i] - 0.5 * (flow.v[i] + trial.v[i]))",
        "(trial.mean_v[i] + 0.5 * (flow.v[i] + trial.v[i]))",
        "physics/test_ledger.py physics/test_conservation.py",
    ),
    Fault(
        "elastic/beams/corotational.py",
        "a, b = -2.0 * rho, -rho * rho",
        "a, b = 2.0 * rho, -rho * rho",
        "physics/test_beam_element.py",
    ),
    Fault(
        "elastic/beams/corotational.py",
        "return p[LENGTH] / 30.0 * (twice1 * x1 - p[BOW12] * x2), p[LENGTH] / 30.0 * (twice2 * x2 - p[BOW12] * x1)",
        "return p[LENGTH] / 30.0 * (twice1 * x1 - p[BOW12] * x2), p[LENGTH] / 30.0 * (twice2 * x2 + p[BOW12] * x1)",
        "physics/test_beam_element.py",
    ),
    Fault(
        "engine/linalg/lu.py",
        "p0, q0 = p0 - a[1] * p1 - a[2] * p2, q0 - a[1] * q1 - a[2] * q2",
        "p0, q0 = p0 - a[1] * p1 - a[2] * p2, q0 - a[1] * q1 - a[1] * q2",
        "linalg/test_two_right_sides.py",
    ),
    Fault(
        "engine/sensitivity/tangent_step.py",
        "T.shift[j] = -(T.z[j, k + place] + s * h * T.z[j, k + LAST_GAP_RATE]) / rate",
        "T.shift[j] = (T.z[j, k + place] + s * h * T.z[j, k + LAST_GAP_RATE]) / rate",
        "dynamics/test_tangent.py dynamics/test_tangent_exponents.py",
    ),
    Fault(
        "parts/contact/hysteresis.py",
        "return 8.0 * (1.0 - restitution) / (5.0 * restitution)",
        "return 5.0 * (1.0 - restitution) / (8.0 * restitution)",
        "contact/test_normal_laws.py contact/test_other_normal_laws.py",
    ),
    Fault(
        "engine/radau/collocation.py",
        "_C = np.array([(4.0 - _ROOT) / 10.0, (4.0 + _ROOT) / 10.0, 1.0])",
        "_C = np.array([(4.0 - _ROOT) / 10.0, (4.1 + _ROOT) / 10.0, 1.0])",
        "physics/test_radau.py",
    ),
)

WINGS = (
    Fault(
        "elastic/planes/elements.py",
        "tx, ty = xy * bx - xx * by, yy * bx - yx * by",
        "tx, ty = xy * bx - xx * by, yy * bx + yx * by",
        "planes/test_cell_kernels.py",
    ),
    Fault(
        "elastic/planes/elements.py",
        "u[2 * k + 1] -= spin * spin * arms[2 * k + 1]",
        "u[2 * k + 1] += spin * spin * arms[2 * k + 1]",
        "planes/test_cell_kernels.py planes/test_full_body.py",
    ),
    Fault(
        "elastic/reduced/kernel.py",
        "imaginary += ax * by - ay * bx",
        "imaginary += ax * by + ay * bx",
        "reduction/test_motion.py",
    ),
    Fault(
        "elastic/reduced/kernel.py",
        "add(0.5 * dot(y, d), along, e)",
        "add(dot(y, d), along, e)",
        "reduction/test_steady_rotation.py reduction/test_motion.py",
    ),
    Fault(
        "parts/cams/curve_on_curve.py",
        "r2x, r2y = X + distance * nx - q[3], Y + distance * ny - q[4]",
        "r2x, r2y = X + distance * nx - q[3], Y - distance * ny - q[4]",
        "cams/test_cams.py cams/test_curves.py",
    ),
    Fault(
        "parts/cams/outline_contact.py",
        "away = size if mx * ex + my * ey >= 0.0 else -size",
        "away = size",
        "cams/test_outlines.py",
    ),
    Fault(
        "parts/controllers/control.py",
        "return 1.0 / time if self.sample is None else -math.expm1(-self.sample / time) / self.sample",
        "return 1.0 / time if self.sample is None else math.expm1(self.sample / time) / self.sample",
        "controllers/test_pid.py controllers/test_sampled.py",
    ),
    Fault(
        "engine/system/elements.py",
        "positions = part_of(C.positions_state, C.pos_state[c], C.pos_state[c + 1])",
        "positions = part_of(C.positions_state, C.pos_state[0], C.pos_state[c + 1])",
        "controllers/test_control.py",
    ),
    Fault(
        "parts/loads/force.py",
        "rate = nx * (v[3] - by * v[5] - v[0] + ay * v[2]) + ny * (v[4] + bx * v[5] - v[1] - ax * v[2])",
        "rate = nx * (v[3] + by * v[5] - v[0] + ay * v[2]) + ny * (v[4] + bx * v[5] - v[1] - ax * v[2])",
        "physics/test_parts.py parts/test_check_part.py",
    ),
    Fault(
        "elastic/planes/loads.py",
        "blocks[..., 0, 1], blocks[..., 1, 0] = -self.normal, self.normal",
        "blocks[..., 0, 1], blocks[..., 1, 0] = self.normal, self.normal",
        "planes/test_loads.py",
    ),
)


def place(copy: Path, fault: Fault) -> str:
    """Put a fault into the copy; the text before it."""
    path = copy / "flexmb" / fault.file
    text = path.read_text(encoding="utf-8")
    if text.count(fault.line) != 1:
        raise SystemExit(f"{fault.file} holds {text.count(fault.line)} times: {fault.line}")
    path.write_text(text.replace(fault.line, fault.wrong), encoding="utf-8")
    return text


def finds(copy: Path, fault: Fault) -> str:
    """The first test that fails in the copy; empty if all pass."""
    env = {**os.environ, "PYTHONPATH": str(copy), "NUMBA_CACHE_DIR": str(copy / ".numba_cache")}
    call = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", "-m", "not slow"]
    call += [f"tests/{name}" for name in fault.tests.split()]
    done = subprocess.run(call, cwd=copy, env=env, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise SystemExit(f"pytest ended with {done.returncode}:\n{done.stdout[-3000:]}{done.stderr[-1000:]}")
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return failed[0].split(" - ")[0].removeprefix("FAILED ") if done.returncode else ""


def main() -> int:
    """A line for each fault; 1 if one was not found."""
    faults = dict(enumerate(CORE + WINGS, 1))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", type=int, choices=list(faults), default=list(faults), metavar="NUMBER")
    chosen, missed = parser.parse_args().only, 0
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "flexmb"
        for name in ("flexmb", "tests", "meshes", "examples", "docs", ".numba_cache"):
            if (ROOT / name).is_dir():
                shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", copy)
        for number in chosen:
            fault, began = faults[number], time.monotonic()
            text = place(copy, fault)
            found = finds(copy, fault)
            (copy / "flexmb" / fault.file).write_text(text, encoding="utf-8")
            missed += not found
            print(f"{number:2d} {fault.file:36s} {found or 'NOT FOUND'}  {time.monotonic() - began:.0f} s", flush=True)
    return 1 if missed else 0


if __name__ == "__main__":
    raise SystemExit(main())
