"""Test bench for the kernels of a part: random states, differences with their errors, reports; checks of elements."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

import numpy as np

from flexmb.engine.system.state_evaluation import StateEvaluation
from flexmb.errors import KernelError
from flexmb.fields import field, record
from flexmb.kernels import Kernel
from flexmb.model.contributions import ControlContribution, Coordinate, ElementContribution
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Part
from flexmb.program.numbering import Numbering
from flexmb.program.program import Program
from flexmb.program.structure import zeros_of_elements

# Numerical derivatives with an estimate of their error

STEPS, ORDERS = 22, 5  # largest numbers of step sizes and of extrapolations
ROUND_OFF = float(np.finfo(float).eps)  # relative round-off of a float


def slope(function: Callable[[float], Any], x: float, scale: float, noise: Any = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """df/dx and its uncertainty, entry by entry, from central differences with steps that shrink from scale / 8."""
    # Each halving of the step is extrapolated (errors in h^2, h^4, ...). The result is the value that differs least
    # from its neighbours, so the step suits the function, and the uncertainty is large at a kink and with round-off.
    # The function of one number gives an array of any shape, and may change over the length `scale` > 0; `noise` is the
    # round-off of its values beyond that of their own size. Source: C. J. F. Ridders, Accurate computation of F'(x) and
    # F'(x)F''(x), Advances in Engineering Software 4 (1982) 75-76.
    best: Any = None
    uncertain: Any = np.inf
    before: list[np.ndarray] = []
    last: Any = np.inf
    blurred: Any = 0.0
    for k in range(STEPS):
        h = scale / 8.0 / 2.0**k
        upper = np.asarray(function(x + h))
        lower = np.asarray(function(x - h))
        span = (x + h) - (x - h)
        row = [(upper - lower) / span]
        for order, older in enumerate(before[:ORDERS], 1):
            factor = 4.0**order
            row.append((factor * row[-1] - older) / (factor - 1.0))
        if k > 0:
            change = np.maximum(np.abs(row[-1] - row[-2]), np.abs(row[-1] - before[-1]))
            change = np.where(np.isfinite(change), change, np.inf)
            blur = (2.0 * ROUND_OFF * np.maximum(np.abs(upper), np.abs(lower)) + noise) / span
            doubt = np.maximum(change, 0.01 * last) + blur  # two values may agree by accident, hardly three
            better = doubt < uncertain
            best = row[-1] if best is None else np.where(better, row[-1], best)
            uncertain = np.where(better, doubt, uncertain)
            last = change
            if np.all((uncertain <= blur) & (blurred <= blur) & (blur < np.inf)):
                break  # round-off grows as the step shrinks: no further value is better
            blurred = blur
        before = row
    return best, uncertain


def gradient(function: Callable[[Any], Any], x: Any, scale: Any, noise: Any = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives by the entries of x and their uncertainties, with the entries of x as last dimension."""
    if np.ndim(x) == 0:
        return slope(function, float(x), float(scale), noise)

    def along(j: int) -> Callable[[float], Any]:
        def moved(s: float) -> Any:
            y = np.array(x)
            y[j] = s
            return function(y)

        return moved

    columns = [slope(along(j), float(x[j]), float(s), noise) for j, s in enumerate(np.broadcast_to(scale, np.shape(x)))]
    return np.stack([c for c, _ in columns], axis=-1), np.stack([u for _, u in columns], axis=-1)


RESULTS = {  # names of returned numbers by contract; other kernels write to arrays
    "energy": ("strain", "gravity", "damping"), "account": ("strain", "gravity", "damping"),
    "normal": ("N", "dN_dgap", "dN_drate"), "friction": ("T", "dT_dslip", "dT_dN"),
    "motion": ("s", "s_dot", "s_ddot"), "signal": ("value",), "extremum": ("value", "place"),
    "damping": ("power", "mixed_power"),
}  # fmt: skip

SAME = 1e-11  # largest difference of compiled and plain Python function, over the largest entry
ROUNDINGS = 100.0  # the same for a signal, over what the last digits of q change: sums over the nodes of a cell
State = dict[str, Any]
Values = dict[str, np.ndarray]


class TestedKernel:
    """A kernel with the parameters p of a part; `owner` for messages, `shapes` of its output arrays by name."""

    def __init__(self, owner: str, kernel: Kernel, p: Sequence[float] | np.ndarray, **shapes: tuple[int, ...]) -> None:
        self.kernel, self.shapes, self.p = kernel, shapes, np.array(p, dtype=float)
        self.label = f"{owner}: {kernel.contract.name} kernel {kernel.name!r}"

    def __call__(self, state: State) -> Values:
        """Outputs of the compiled function by name, at a `state`."""
        return self._outputs(self.kernel.dispatcher, state)

    def of(self, state: State, output: str, name: str, part: Any = slice(None)) -> Callable[[Any], np.ndarray]:
        """A part of an output, or a whole one, as a function of one input beside a state."""
        return lambda x: np.atleast_1d(self({**state, name: x})[output])[part]

    def checked_call(self, state: State, sizes: dict[str, float] | None = None) -> Values:
        """Outputs at a state, after the checks of a single call."""
        # Round-off is related to `sizes` of outputs by name; others: to their own. A `KernelError` tells a call
        # that fails or changes its inputs, values that are not finite, other results of a second or compiled call.
        first, second = self._python(state), self._python(state)
        for name, value in first.items():
            self._finite(name, value, state)
            where = value != second[name]
            if np.any(where):
                both = f"{at(value, where):.17g} and then {at(second[name], where):.17g}"
                text = f"{entry(name, where)} is {both} for the same input"
                raise self.fault(f"{text}; a kernel may remember nothing but z", state)
        compiled = self(state)
        derived = RESULTS[self.kernel.contract.name][1:] if self.kernel.is_alone else ()  # by differences of the first
        for name, value in first.items():
            self._finite(name, compiled[name], state)
            if name in derived:
                continue
            where = np.abs(compiled[name] - value) > SAME * self._size(name, first, state, sizes or {})
            if np.any(where):
                both = f"{at(compiled[name], where):.12g} compiled and {at(value, where):.12g} in plain Python"
                raise self.fault(f"{entry(name, where)} is {both}", state)
        return compiled

    def fault(self, text: str, state: State) -> KernelError:
        """The error to be raised, with the state."""
        with np.printoptions(precision=5, linewidth=10**6):
            listed = ", ".join(f"{name} = {np.asarray(x)}" for name, x in state.items())
        return KernelError(f"{self.label}: {text}. State: {listed}.")

    def _finite(self, name: str, value: np.ndarray, state: State) -> None:
        if np.any(bad := ~np.isfinite(value)):
            raise self.fault(f"{entry(name, bad)} is {at(value, bad)}; it must be finite at every state", state)

    def same(self, state: State, expected: Values, sizes: dict[str, float], other: str) -> None:
        """Check that the outputs agree with outputs of another kernel up to round-off, related to `sizes`."""
        values = self.checked_call(state, sizes)
        for name, value in expected.items():
            where = np.abs(values[name] - value) > SAME * self._size(name, expected, state, sizes)
            if np.any(where):
                both = f"{at(values[name], where):.12g}, where {other!r} gives {at(value, where):.12g}"
                raise self.fault(f"{entry(name, where)} is {both}; both must say the same", state)

    def _size(self, name: str, values: Values, state: State, sizes: dict[str, float]) -> float:
        """Magnitude to which round-off is related: a force is a difference of terms as large as K q."""
        size = float(np.abs(values[name]).max(initial=0.0)) + sizes.get(name, 0.0)
        if name in sizes:
            return size
        for output, matrix in (("r", "K"), ("g", "G")):
            if name == output:
                size += float(np.abs(values[matrix]).max(initial=0.0) * np.abs(state["q"]).max(initial=1.0))
        if name in ("strain", "gravity"):
            size += float(np.abs(values["strain"]) + np.abs(values["gravity"]))
        if name == "value":  # a signal, such as a stress, by differences of places: what their last digit changes
            near = self({**state, "q": np.nextafter(state["q"], np.inf)})[name]
            size += ROUNDINGS / SAME * abs(float(near - values[name]))
        return size

    def _python(self, state: State) -> Values:
        """Outputs of the plain Python function, given copies of the inputs."""
        mine = {name: x.copy() if isinstance(x, np.ndarray) else x for name, x in state.items()} | {"p": self.p.copy()}
        try:
            with np.errstate(all="ignore"):
                outputs = self._outputs(self.kernel.python, mine)
        except (ArithmeticError, ValueError, IndexError, TypeError) as error:
            raise self.fault(f"fails in plain Python with {type(error).__name__} ({error})", state) from error
        for name, x in {**state, "p": self.p}.items():
            if not np.array_equal(mine[name], x):
                raise self.fault(f"changes its input {name}; write to the outputs only", state)
        return outputs

    def _outputs(self, function: Callable[..., Any], state: State) -> Values:
        outputs = {name: np.zeros(shape) for name, shape in self.shapes.items()}
        given = {"p": self.p, "least": -1.0, **state, **outputs}  # an extremum is wanted, however small
        result = function(*(given[name] for name in self.kernel.contract.parameters))
        names = RESULTS.get(self.kernel.contract.name, ())
        numbers = np.atleast_1d(np.array(result, dtype=float)) if names else ()
        return {**outputs, **dict(zip(names, numbers, strict=True))}


def entry(name: str, where: Any) -> str:
    """Name of the first marked entry, such as 'K[0, 1]'."""
    if np.ndim(where) == 0 or np.size(where) == 1:
        return name
    return f"{name}[{', '.join(str(k) for k in np.argwhere(where)[0])}]"


def at(values: Any, where: Any) -> float:
    """Value of the first marked entry."""
    return float(np.atleast_1d(values)[np.atleast_1d(where)][0])


TOLERANCE = 1e-6  # largest relative error of a derivative, over the largest entry of its row
SMALL_ROW = 1e-4  # size of a row, over the largest row, below which its errors are related to the largest row
HIDDEN = 1e-6  # change of a function over its scale, over the function, below which errors are over the function
BALANCE = 1e-12  # largest imbalance of forces and moments, over the sum of their magnitudes
TURNED = 1e-11  # largest relative change of a result by a rotation and shift of the frame
MAGNITUDES = (1e-6, 1e-3, 0.05, 0.3)  # distances of states from the reference: over the size of the piece, in rad
Round = TypeVar("Round")


@record
class Check:
    """One line of a report."""

    name: str = field("kernel and checked property")
    states: int = field("number of states")
    error: float = field("largest relative error", default=0.0)
    skipped: int = field("number of further states at a kink, which were left out", default=0)


@record
class Report:
    """Result of `check_part`; `str(report)` is a readable table."""

    part: str = field("name and class of the part")
    checks: tuple[Check, ...] = field("lines of the report")

    def __str__(self) -> str:
        width = max((len(c.name) for c in self.checks), default=0)
        lines = [f"{self.part}: keeps its contracts"]
        for c in self.checks:
            left_out = f", {c.skipped} at kinks left out" if c.skipped else ""
            lines.append(f"  {c.name:{width}s}  {c.states:4d} states, largest error {c.error:.1e}{left_out}")
        return "\n".join(lines)


class Bench:
    """Test bench for the kernels of one part; `seed` is that of the random states."""

    def __init__(self, mechanism: Mechanism, part: Part, seed: int) -> None:
        self.owner = f"Part {part.name!r} ({type(part).__name__})"
        self.number = Numbering(mechanism)
        self.pose = np.concatenate([self.number.pose(), np.zeros(3)])
        self.random = np.random.default_rng(seed)
        self.errors: dict[str, list[float]] = {}
        self.skipped: dict[str, int] = {}

    def report(self) -> Report:
        """Report of all checks so far."""
        names = dict.fromkeys([*self.errors, *self.skipped])
        checks = [(n, self.errors.get(n, []), self.skipped.get(n, 0)) for n in names]
        return Report(self.owner, tuple(Check(n, len(e), max(e, default=0.0), s) for n, e, s in checks))

    def note(self, name: str, error: float = 0.0) -> None:
        """Record a passed check: kernel and checked property, and its relative error."""
        self.errors.setdefault(name, []).append(float(error))

    def scales(self, coordinates: Sequence[Coordinate]) -> np.ndarray:
        """Scales of `coordinates`: the size of the piece for lengths, 1 for angles."""
        q = self.pose[self.number.dofs(coordinates)]
        extent = [np.ptp([x for x, c in zip(q, coordinates, strict=True) if c[2] == k] or [0.0]) for k in (0, 1)]
        size = math.hypot(*extent) or self.number.extent
        return np.array([1.0 if axis == 2 else size for _, _, axis in coordinates])

    def states(self, coordinates: Sequence[Coordinate], wanted: str) -> Iterator[State]:
        """Random states of each magnitude, every second in motion, some of h = 0; `wanted`: names between blanks."""
        q, scale = self.pose[self.number.dofs(coordinates)], self.scales(coordinates)
        for k in range(3 * len(MAGNITUDES)):
            inputs = {
                "t": float(self.random.uniform(0.0, 2.0)),
                "h": (0.0, 1e-4, 1e-2)[k % 3],
                "q": q + MAGNITUDES[k // 3] * scale * self.random.uniform(-1.0, 1.0, len(q)),
                "v": 10.0 * (k % 2) * scale * self.random.uniform(-1.0, 1.0, len(q)),
                "a": 100.0 * (k % 2) * scale * self.random.uniform(-1.0, 1.0, len(q)),
            }
            yield {name: inputs[name] for name in wanted.split()}

    def derivative(
        self, tested: TestedKernel, formula: str, state: State, value: Any, function: Any, x: Any, scale: Any,
        **sizes: Any,
    ) -> None:  # fmt: skip
        """Compare a derivative of the kernel with differences of a function at x."""
        # The formula begins with the name of the derivative; `scale` is that of the differences. `sizes` are `rows`,
        # `columns`: weights that give all entries one unit; `floor`: smallest size of a row; `noise`: round-off of the
        # function beyond that of its own size; `found`: differences and uncertainties, where they are known.
        expected, uncertain = sizes.get("found") or gradient(function, x, scale, sizes.get("noise", 0.0))
        value = np.asarray(value, dtype=float)
        expected, uncertain = expected.reshape(value.shape), uncertain.reshape(value.shape)
        weight = np.asarray(sizes.get("rows", 1.0))
        if value.ndim == 2:
            weight = np.broadcast_to(weight, value.shape[:1])[:, None] * sizes.get("columns", 1.0)
        size = np.abs(expected * weight)
        if value.ndim == 2:
            size = size.max(axis=1, keepdims=True, initial=0.0)
        # a derivative this small against the function itself is hidden by round-off
        hidden = HIDDEN * np.abs(function(x) * np.asarray(sizes.get("rows", 1.0))).max(initial=0.0)
        hidden *= np.max(np.asarray(sizes.get("columns", 1.0)) / scale)
        floor = max(SMALL_ROW * size.max(initial=0.0), sizes.get("floor", 0.0), float(hidden), 1e-300)
        size, name = np.maximum(size, floor), f"{tested.kernel.name}: {formula}"
        doubtful = uncertain * weight > 0.1 * TOLERANCE * size
        if np.any(doubtful):
            # Leave out a state at a kink; too many such states are an error
            self.skipped[name] = self.skipped.get(name, 0) + 1
            states = self.skipped[name] + len(self.errors.get(name, ()))
            if self.skipped[name] > max(4, states // 3):
                place = entry(formula.split(maxsplit=1)[0], doubtful)
                count = f"{self.skipped[name]} of {states} states"
                text = f"{place}: no derivative is found at {count}; the values must change smoothly, without noise"
                raise tested.fault(text, state)
            return
        error = np.abs(value - expected) * weight / size
        wrong = error > TOLERANCE
        if np.any(wrong):
            place = entry(formula.split(maxsplit=1)[0], wrong)
            both = f"the kernel says {at(value, wrong):.9g}, differences say {at(expected, wrong):.9g}"
            text = f"{place}: {both} (relative error {at(error, wrong):.2g}); it must be {formula}"
            raise tested.fault(text, state)
        self.note(name, error.max(initial=0.0))

    def balanced(self, tested: TestedKernel, quantity: str, state: State, terms: Sequence[float], rule: str) -> None:
        """Check that the sum of terms vanishes."""
        imbalance, size = float(np.sum(terms)), float(np.abs(terms).sum())
        if abs(imbalance) > BALANCE * size:
            text = f"{quantity} are out of balance by {imbalance:.6g}, where their sizes add up to {size:.6g}"
            raise tested.fault(f"{text}; {rule}", state)
        self.note(f"{tested.kernel.name}: {quantity} in balance", abs(imbalance) / size if size else 0.0)

    def turned(self, tested: TestedKernel, name: str, state: State, after: Any, before: Any, size: float) -> None:
        """Compare results `after` in a moved frame with rotated ones of `before`, related to the magnitude `size`."""
        error = np.abs(np.asarray(after) - before) / max(size, 1e-300)
        wrong = error > TURNED
        if np.any(wrong):
            both = f"{at(after, wrong):.12g}, not {at(before, wrong):.12g}"
            text = f"{entry(name, wrong)} depends on the frame: with everything turned and shifted it is {both}"
            raise tested.fault(text, state)
        self.note(f"{tested.kernel.name}: turned and shifted", np.max(error, initial=0.0))

    def rotation(self, scale: float) -> tuple[np.ndarray, np.ndarray]:
        """A random rotation of two nodes (6, 6), and the shift of at most `scale` [m] and turn (6,) after it."""
        angle = float(self.random.uniform(-3.0, 3.0))
        c, s = math.cos(angle), math.sin(angle)
        turn = np.kron(np.eye(2), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
        dx, dy = scale * self.random.uniform(-1.0, 1.0, 2)
        return turn, np.array([dx, dy, angle, dx, dy, angle])


REACTION = "action must equal reaction; a load from outside on two bodies is one part for each of them"


def check_element(bench: Bench, contribution: ElementContribution, weightless: ElementContribution) -> None:
    """Check an element (`weightless`: without gravity): tangents, energies, balance, frame, other kernels."""
    n, m = len(contribution.coordinates), len(contribution.history)
    shapes = {"r": (n,), "K": (n, n), "C": (n, n), "M": (n, n), "z_new": (m,)}
    tested = TestedKernel(bench.owner, contribution.kernel, contribution.p, **shapes)
    bare = TestedKernel(bench.owner, weightless.kernel, weightless.p, **shapes)
    scale, z = bench.scales(contribution.coordinates), np.array(contribution.history, dtype=float)
    for state in bench.states(contribution.coordinates, "t h q v a"):
        full = {**state, "z": z}
        out = tested.checked_call(full)
        bench.note(f"{contribution.kernel.name}: compiled = Python, finite, repeatable")
        for name in "KCM":
            check_zeros(bench, tested, name, zeros_of_elements([contribution]), full, out)
        # Compare K, C and M with differences of r
        size = float(np.abs(out["r"] * scale).max())
        sizes = {"rows": scale, "columns": scale, "floor": TOLERANCE * size}
        for output, name in (("K", "q"), ("C", "v"), ("M", "a")):
            step, noise = scale, 0.0
            if name == "q":  # a force is a difference of terms as large as K q
                noise = ROUND_OFF * np.abs(out["K"]) @ np.abs(full["q"])
            else:  # rates at which C v or M a is as large as the other forces, so that round-off does not hide them
                strongest = float(np.abs(out[output] * np.outer(scale, scale)).max())
                step = scale * np.clip(size / strongest if strongest else 1.0, 1.0, 1e6)
            formula, force = f"{output} = dr/d{name}", tested.of(full, "r", name)
            bench.derivative(tested, formula, full, out[output], force, full[name], step, noise=noise, **sizes)
        check_other_kernels(bench, contribution, tested, full, out)
        if contribution.energy is not None and not m:
            check_energy(bench, contribution.energy, tested, full, out, scale)
        check_reaction(bench, contribution.coordinates, bare, full)
        check_frame(bench, contribution.coordinates, bare, full, scale)
        z = out["z_new"]


def check_zeros(bench: Bench, tested: TestedKernel, name: str, zeros: np.ndarray, state: State, out: Values) -> None:
    """Refuse entries that are not zero though a contribution declares them as zero."""
    if not zeros.any():
        return
    where = (out[name].ravel() != 0.0) & zeros
    if where.any():
        row, column = divmod(int(np.argmax(where)), out[name].shape[1])
        text = f"{name}[{row}, {column}] is {out[name][row, column]:.3g}, and the contribution says that it is always 0"
        raise tested.fault(f"{text}; name it in columns or curved, or leave diagonal out", state)
    bench.note(f"{tested.kernel.name}: {name} is 0 where that is declared")


def check_other_kernels(
    bench: Bench, contribution: ElementContribution, tested: TestedKernel, state: State, out: Values
) -> None:
    """Compare force, tangent, energy-evaluation and damping kernel with the element and energy kernels."""
    n, history = tested.shapes["r"], {"z_new": tested.shapes["z_new"]}
    weights = dict(zip(("kq", "kv", "ka"), bench.random.uniform(0.5, 2.0, 3).tolist(), strict=True))
    y = bench.random.uniform(-1.0, 1.0, n)
    matrix = sum(weight * out[name] for weight, name in zip(weights.values(), "KCM", strict=True))
    expected: dict[str, Any] = {"r": out["r"], "z_new": out["z_new"]}
    account = {**expected, "Mv": out["M"] @ state["v"], "My": out["M"] @ y}
    powers: dict[str, Any] = {}
    if contribution.energy is not None:
        energy = TestedKernel(bench.owner, contribution.energy, contribution.p)
        given = {name: state[name] for name in ("t", "q")}
        account |= energy({**given, "v": state["v"]})
        more, less = (energy({**given, "v": state["v"] + w})["damping"] for w in (y, -y))
        powers = {"power": account["damping"], "mixed_power": 0.25 * (more - less)}
    sizes = round_off_sizes(tested, state, out)
    sizes |= dict.fromkeys(powers, float(np.abs(out["C"]).sum()) * (1.0 + float(np.abs(state["v"]).max())) ** 2)
    sizes |= {"Mv": float((np.abs(out["M"]) @ np.abs(state["v"])).max()), "My": float(np.abs(out["M"]).sum())}
    tangent = (contribution.tangent, weights, {"A": (*n, *n)}, {**expected, "A": matrix})
    account_of = (contribution.account, {"y": y}, {"Mv": n, "My": n}, account)
    damping: Any = (contribution.damping, {"w": y}, {}, powers)
    kernels: Any = ((contribution.force, {}, {}, expected), tangent, account_of, damping)
    for kernel, inputs, results, values in kernels:
        if kernel is not None:
            other = TestedKernel(bench.owner, kernel, contribution.p, r=n, **results, **history)
            other.same({**state, **inputs}, values, sizes, contribution.kernel.name)
            bench.note(f"{kernel.name}: as {contribution.kernel.name}")


def round_off_sizes(tested: TestedKernel, state: State, out: Values) -> dict[str, float]:
    """Magnitudes of forces and energies to which round-off is related: coordinates have a round-off of their own."""
    q, v = (float(np.abs(state[name]).max(initial=1.0)) for name in "qv")
    stiffness, still = float(np.abs(out["K"]).max()), np.zeros_like(state["v"])
    rest = float(np.abs(tested({**state, "v": still, "a": still})["r"]).max())
    stored, moved = (rest + 1e-16 * stiffness * q) * q, float(np.abs(out["r"]).max()) + stiffness * q
    return {"r": moved, "strain": stored, "gravity": stored, "damping": float(np.abs(out["C"]).sum()) * v * v}


def check_energy(
    bench: Bench, kernel: Kernel, tested: TestedKernel, state: State, out: Values, scale: np.ndarray
) -> None:
    """Compare the force at rest with the potential, and the power of the forces with the rate of all energies."""
    energy = TestedKernel(bench.owner, kernel, tested.p)
    short = {name: state[name] for name in ("t", "q", "v")}
    damping = float(energy.checked_call(short, round_off_sizes(tested, state, out))["damping"])
    v, still = state["v"], np.zeros_like(state["v"])

    def potential(q: np.ndarray) -> float:
        energies = energy({**short, "q": q})
        return float(energies["strain"] + energies["gravity"])

    def stored(s: float) -> float:
        q = state["q"] + s * v
        return potential(q) + 0.5 * float(v @ tested({**state, "q": q})["M"] @ v)

    # both potentials, and the stiffness times the round-off of coordinates, limit what differences can find
    terms = energy(short)
    floor = 1e-3 * float(abs(terms["strain"]) + abs(terms["gravity"]))
    floor = max(floor, 1e-8 * float(np.abs(out["K"] * np.outer(scale, scale)).max(initial=0.0)))
    force = tested({**state, "v": still, "a": still})["r"]
    sizes = {"columns": scale, "floor": floor}
    bench.derivative(energy, "force = dV/dq", state, force[None, :], potential, state["q"], scale, **sizes)
    if np.any(v):
        r = tested({**state, "a": still})["r"]
        floor = max(floor, float(np.abs(v * r).sum()))
        rate = float(v @ r) - damping
        bench.derivative(energy, "power = d(T + V)/dt + damping", state, rate, stored, 0.0, 0.1, floor=floor)


def check_reaction(bench: Bench, coordinates: Sequence[Coordinate], tested: TestedKernel, state: State) -> None:
    """Check that forces and moments between two moving bodies balance, by an element without gravity and inertia."""
    parts = {part for part, _, _ in coordinates}
    if len(parts) != 2 or GROUND.name in parts:
        return
    state = {**state, "a": np.zeros_like(state["a"])}
    if np.any(tested(state)["M"]):
        state["v"] = np.zeros_like(state["v"])
    nodes: dict[tuple[str, str], dict[int, int]] = {}
    for i, (part, node, axis) in enumerate(coordinates):
        nodes.setdefault((part, node), {})[axis] = i
    r, q = tested(state)["r"], state["q"]
    for axis in (0, 1):
        terms = [r[axes[axis]] for axes in nodes.values() if axis in axes]
        bench.balanced(tested, f"forces along {'xy'[axis]}", state, terms, REACTION)
    if any((0 in axes) != (1 in axes) for axes in nodes.values()):
        return  # the place of a force must be known for its moment
    terms = [r[axes[2]] for axes in nodes.values() if 2 in axes]
    for axes in nodes.values():
        if 0 in axes:
            terms += [q[axes[0]] * r[axes[1]], -q[axes[1]] * r[axes[0]]]
    bench.balanced(tested, "moments about the origin", state, terms, REACTION)


def check_frame(
    bench: Bench, coordinates: Sequence[Coordinate], tested: TestedKernel, state: State, scale: np.ndarray
) -> None:
    """Check that the forces of an element with two nodes turn with the frame, without gravity."""
    if [axis for _, _, axis in coordinates] != [0, 1, 2, 0, 1, 2]:
        return
    turn, shift = bench.rotation(scale[0])
    moved = {**state, "q": turn @ state["q"] + shift, "v": turn @ state["v"], "a": turn @ state["a"]}
    before, after = tested(state), tested(moved)
    # a force is a difference of terms as large as K q
    stiffness = float(np.abs(before["K"] * np.outer(scale, scale)).max())
    size = stiffness * float(np.abs(moved["q"] / scale).max()) + float(np.abs(before["r"] * scale).max())
    bench.turned(tested, "r", state, after["r"] * scale, (turn @ before["r"]) * scale, size)


INPUT_SIZES = (0.0, 1e-3, 1.0, 30.0)  # sizes of random inputs and states of a law
# Sizes of random displacements, over the size of the mechanism and in rad, and of velocities per second.
POSE_SIZES, SPEED_SIZES = (0.01, 0.3, 1.0, 2.0), (0.0, 0.1, 3.0)
ROUNDS = 6  # number of states of each size of displacement and velocity
SETTLING = 5  # number of iterations that bring states of a control near rest, where the control is not saturated
SMALL = 1e-9  # slopes relative to the largest one, below which they are round-off
# Derivative relative to the forces, below which round-off of the differences of a law exceeds the tolerance: the
# program finds tangents of laws by differences of its own, of at least 6e-7.
LAW_NOISE = 4e-3


def check_control(bench: Bench, contribution: ControlContribution) -> None:
    """Check calls of a control law with random inputs: compiled = Python, repeatable, inputs unchanged."""
    # Inputs at which the law is not finite are left out, since the mechanism may never have them.
    tested = tested_law(bench, contribution)
    name, finite = f"{contribution.kernel.name}: compiled = Python, repeatable, inputs unchanged", 0
    for size in INPUT_SIZES * ROUNDS:
        u = size * bench.random.uniform(-1.0, 1.0, len(contribution.inputs))
        x = np.array(contribution.start) + size * bench.random.uniform(-1.0, 1.0, len(contribution.states))
        state: dict[str, Any] = {"t": float(bench.random.uniform(0.0, 2.0)), "u": u, "x": x}
        with np.errstate(all="ignore"):
            values = tested(state)
        if all(np.isfinite(value).all() for value in values.values()):
            finite += 1
            tested.checked_call(state)
            bench.note(name)
    if not finite:
        raise tested.fault("its rates dx or outputs y are finite for none of the inputs that were tried", state)


def tested_law(bench: Bench, contribution: ControlContribution) -> TestedKernel:
    """The law of a control under test."""
    sizes = {"dx": (len(contribution.states),), "y": (len(contribution.outputs),)}
    return TestedKernel(bench.owner, contribution.kernel, contribution.p, **sizes)


def check_control_tangents(bench: Bench, program: Program, contribution: ControlContribution) -> None:
    """Compare the tangents of loads and states of a control with differences of the forces of the mechanism."""
    # A state of the mechanism at which the outputs depend on nothing (a saturated controller) tells nothing of
    # tangents; so there must be others. A sampled control has no tangents.
    c, C, E = program.controls.index(contribution.part), program.tables.controls, program.tables.elements
    columns = np.asarray(C.dofs[C.dof[c] : C.dof[c + 1]]).astype(np.int64)
    if contribution.sample is not None or len(columns) == 0:
        return
    begin, end = C.slope[C.output[c : c + 2]]
    loads = [program.names.elements.index(load) for load in contribution.loads]
    loaded = [int(dof) for e in loads for dof in E.dofs[E.dof[e] : E.dof[e + 1]] if dof < program.n_q]
    rows = np.array([*columns[: len(contribution.states)], *loaded], dtype=np.int64)
    tested, acting = tested_law(bench, contribution), 0
    for state in _states(bench, program, contribution, columns):
        system = StateEvaluation(program).at(state["q"], state["v"], state["a"], t=state["t"], weights=(0.7, 0.4, 0.0))
        if not np.any(system.work.slope[begin:end]):
            continue
        acting += 1
        _compare(bench, tested, program, state, rows, columns)
    if not acting:
        text = "its outputs depend on no input and no state at any state that was tried (a saturated controller, or a"
        text += " law that switches), so that its tangents are not tested"
        raise KernelError(f"{tested.label}: {text}; check it with wider limits, or give a switching law sample=.")


def _states(bench: Bench, program: Program, contribution: ControlContribution, columns: np.ndarray) -> Any:
    """Random states of the mechanism, with states of the control near rest."""
    n_b, n = program.tables.sizes.n_b, program.n_q
    scale = np.where(np.asarray(program.tables.kind[:n_b]) == 1, 1.0, program.length)
    own = columns[: len(contribution.states)]
    for pose in POSE_SIZES:
        for speed in SPEED_SIZES:
            for _ in range(ROUNDS):
                q, v, a = np.array(program.reference.q), np.zeros(n), np.zeros(n)
                q[:n_b] += pose * scale * bench.random.uniform(-1.0, 1.0, n_b)
                v[:n_b] = speed * scale * bench.random.uniform(-1.0, 1.0, n_b)
                t, system = float(bench.random.uniform(0.0, 2.0)), StateEvaluation(program)
                for _ in range(SETTLING if len(own) else 0):
                    rates = system.at(q, v, t=t, weights=(0.0, 1.0, 0.0)).force[own]
                    v[own] -= np.linalg.lstsq(system.dense[np.ix_(own, own)], rates, rcond=SMALL)[0]
                v[own] += 1e-3 * np.abs(v[own]) * bench.random.uniform(-1.0, 1.0, len(own))
                yield {"t": t, "q": q, "v": v, "a": a}


def _compare(
    bench: Bench, tested: TestedKernel, program: Program, state: dict[str, Any], rows: np.ndarray, columns: np.ndarray
) -> None:
    """Compare the rows of the matrix, by the coordinates of a control and their velocities, with differences."""
    system = StateEvaluation(program)
    scale = np.where(np.asarray(program.tables.kind)[columns] == 1, 1.0, program.length)
    force = np.abs(system.at(state["q"], state["v"], state["a"], t=state["t"]).force[rows])
    for name, weights, formula in (("q", (1.0, 0.0, 0.0), "K = dr/dq"), ("v", (0.0, 1.0, 0.0), "C = dr/dv")):
        matrix = system.at(state["q"], state["v"], state["a"], t=state["t"], weights=weights).dense
        value = matrix[np.ix_(rows, columns)]

        def forces(x: np.ndarray, name: str = name) -> np.ndarray:
            moved = {**state, name: state[name].copy()}
            moved[name][columns] = x
            return np.asarray(system.at(moved["q"], moved["v"], moved["a"], t=state["t"]).force[rows])

        floor = LAW_NOISE * float(force.max(initial=0.0) / scale.min())
        bench.derivative(tested, formula, state, value, forces, state[name][columns], scale, floor=floor)
