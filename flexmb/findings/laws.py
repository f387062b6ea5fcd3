"""Findings on laws, kernels and prescribed motions: signs, derivatives, contracts, jumps."""

from collections.abc import Callable, Container, Iterator

import numpy as np

from flexmb.errors import USER_ERRORS, KernelError
from flexmb.findings.finding import Finding, found
from flexmb.kernels import Kernel
from flexmb.model.contributions import AngleContribution, ContactContribution, Contribution, ElementContribution
from flexmb.model.law import FrictionLaw, Motion, NormalLaw, values_of
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Part
from flexmb.testing.bench import Bench
from flexmb.testing.part import check_piece

# Prescribed motions: rates that belong to their values, jumps that are announced, tables that do not overshoot

PLACES = 64  # instants at which rates are compared with differences, and intervals that are searched for jumps
SPAN_WITHOUT_PERIOD = 1.0  # time that is looked at, of a motion without period or breaks [s]
DIFFERENCE = 1e-5  # step of the differences, relative to that time
MISMATCH = 1e-3  # difference relative to the largest rate, or to the range of the value, above which something is wrong
HALVINGS = 40  # number of halvings by which a jump is located


def motions_by_part(mechanism: Mechanism) -> Iterator[tuple[str, Motion]]:
    """Every prescribed motion and history, with the name of its part."""
    return ((p.name, value) for p in mechanism.parts for value in vars(p).values() if isinstance(value, Motion))


def motion_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on all motions of a mechanism."""
    motions = motions_by_part(mechanism)
    return [one for name, motion in motions for one in (*motion.findings(name), *wrong_rates(name, motion))]


def wrong_rates(name: str, motion: Motion) -> list[Finding]:
    """Findings on rates that are not the derivatives of their values, on jumps, and on values that are not finite."""
    breaks = tuple(motion.breaks(1e3))
    span = motion.period or max([SPAN_WITHOUT_PERIOD, *(1.2 * t for t in breaks)])
    p = np.array(motion.parameters(), dtype=float)

    def at(t: float) -> np.ndarray:
        return values_of(motion.kernel, p, float(t))

    times = span * (np.arange(PLACES) + 0.381966) / PLACES
    values = np.array([at(t) for t in times])
    if not np.isfinite(values).all():
        t, reason = float(times[np.flatnonzero(~np.isfinite(values).all(axis=1))[0]]), "is not finite"
        try:
            with np.errstate(all="ignore"):
                np.array(motion.kernel(p, t), dtype=float)
        except USER_ERRORS as error:
            reason = f"fails with {type(error).__name__} ({error})"
        text = f"The motion of {name!r} {reason} at t = {t:.6g} s."
        remedy = "Let its kernel return three finite numbers at every t; after its end a motion stands still."
        return [found("broken-kernel", (name,), text, remedy, time=t)]
    findings = [*_wrong_rate(name, at, times, values, span, 0), *_wrong_rate(name, at, times, values, span, 1)]
    return findings or _jump(name, at, np.linspace(0.0, span, PLACES + 1), breaks)


def _wrong_rate(
    name: str, at: Callable[[float], np.ndarray], times: np.ndarray, values: np.ndarray, span: float, k: int
) -> list[Finding]:
    """Finding on derivative k + 1 of a motion that differs from differences of derivative k at most instants."""
    words, h = ("value", "rate", "second derivative"), DIFFERENCE * span
    wide, narrow = (np.array([(at(t + s)[k] - at(t - s)[k]) / (2.0 * s) for t in times]) for s in (h, 0.5 * h))
    round_off = 1e-15 * np.abs(values[:, k]).max() / h
    wrong = np.abs(narrow - values[:, k + 1])
    largest = max(np.abs(values[:, k + 1]).max(), np.abs(narrow).max())
    bad = wrong > MISMATCH * largest + 10.0 * np.abs(wide - narrow) + 100.0 * round_off
    if bad.mean() <= 0.5:
        return []
    worst = int(np.argmax(np.where(bad, wrong, 0.0)))
    text = f"The {words[k + 1]} of {name!r} is not the derivative of its {words[k]}: at t = {times[worst]:.6g} s the"
    text = f"{text} kernel returns {values[worst, k + 1]:.6g}, differences give {narrow[worst]:.6g}."
    remedy = "Let the kernel return s, ds/dt and d2s/dt2 of one function."
    return [found("wrong-rate", (name,), text, remedy, time=times[worst], difference=wrong[worst])]


def _jump(name: str, at: Callable[[float], np.ndarray], edges: np.ndarray, breaks: tuple[float, ...]) -> list[Finding]:
    """Finding on a value that jumps at an instant that is no break."""
    ends = np.array([at(t) for t in edges])
    size = max(float(np.ptp(ends[:, 0])), 1e-300)
    for k in np.argsort(-np.abs(np.diff(ends[:, 0]) - 0.5 * np.diff(edges) * (ends[1:, 1] + ends[:-1, 1])))[:8]:
        low, high = float(edges[k]), float(edges[k + 1])
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            first, last = (abs(at(b)[0] - at(a)[0]) for a, b in ((low, middle), (middle, high)))
            low, high = (low, middle) if first > last else (middle, high)
        jump = float(at(high)[0] - at(low)[0])
        announced = any(abs(t - high) <= 1e-6 * edges[-1] for t in breaks)
        if abs(jump) > MISMATCH * size and not announced:
            text = f"The value of {name!r} jumps by {jump:.4g} at t = {high:.6g} s."
            remedy = "Make it continuous, or let `breaks` return that instant; a joint needs a value without jumps."
            return [found("jumping-drive", (name,), text, remedy, time=high, jump=jump)]
    return []


SPEEDS = (-3.0, -0.1, -1e-3, 0.0, 1e-3, 0.1, 3.0)  # gap rates of the tries [m/s]
FAST_SLIPS = (-10.0, 10.0)  # slips at which friction must brake [m/s]; the friction of a belt may drive at slower ones
DEPTHS = (0.01, 0.3, 1.0)  # gaps and penetrations of the tries, relative to the clearance
LOADS = (1.0, 100.0)  # normal forces of the tries [N]
SMALL_GAP = 1e-4  # gap of the tries where the clearance is 0 [m]


def law_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on the signs of all contact and friction laws of a mechanism."""
    findings: list[Finding] = []
    for part in mechanism.parts:
        for contribution in () if isinstance(part, Body) else contacts_of(part, mechanism):
            findings += normal_sign(part.name, contribution.normal, abs(contribution.p[0]) or SMALL_GAP)
        for law in dict.fromkeys(value for value in vars(part).values() if isinstance(value, FrictionLaw)):
            findings += friction_sign(part.name, law)
    return findings


def contacts_of(part: Part, mechanism: Mechanism) -> list[ContactContribution]:
    """Contacts of a part; one of each normal law."""
    if not any(isinstance(value, NormalLaw) for value in vars(part).values()):
        return []
    contacts = [c for c in part.contributions(mechanism) if isinstance(c, ContactContribution)]
    return list({(type(c.normal), tuple(c.normal.parameters())): c for c in contacts}.values())


def normal_sign(name: str, law: NormalLaw, gap: float) -> list[Finding]:
    """Findings on a normal law that pushes at a distance or pulls in contact, at gaps of the size `gap` [m]."""
    p, h = np.array(law.parameters(), dtype=float), 1e-5
    for depth in DEPTHS:
        for rate in SPEEDS:
            z = np.array(law.history(), dtype=float)
            z_new = z.copy()
            N = float(values_of(law.kernel, p, h, depth * gap, rate, z, z_new)[0])
            place, why = "gap", ", where the surfaces are apart"
            if N == 0.0 or np.isnan(N):  # what is not a number is told by `kernel_findings`
                N = float(values_of(law.kernel, p, h, -depth * gap, rate, z_new.copy(), np.zeros_like(z))[0])
                place, why = "penetration", "; a contact can only push"
                if not N < 0.0:
                    continue
            text = f"The normal law of {name!r} gives N = {N:.4g} N at a {place} of {depth * gap:.4g} m"
            remedy = "Return 0 where the gap is positive, and never less than 0."
            return [found("pulling-contact", (name,), f"{text} (gap rate {rate:g} m/s){why}.", remedy)]
    return []


def friction_sign(name: str, law: FrictionLaw) -> list[Finding]:
    """Findings on a friction law whose force drives its surfaces."""
    p, h = np.array(law.parameters(), dtype=float), 1e-5
    for load in LOADS:
        for slip in FAST_SLIPS:
            z = np.array(law.history(), dtype=float)
            for _ in range(3):  # a law with history may begin at rest
                z_new = z.copy()
                T = float(values_of(law.kernel, p, h, slip, load, z, z_new)[0])
                z = z_new
            if T * slip > 0.0:
                text = f"The friction law of {name!r} gives T = {T:.4g} N along a slip of {slip:g} m/s (N = {load:g} N)"
                remedy = "Friction brakes: return T with the sign of -slip."
                return [found("driving-friction", (name,), f"{text}: it drives.", remedy, force=T, slip=slip)]
    return []


def kernel_findings(mechanism: Mechanism, known: Container[str] = ()) -> list[Finding]:
    """Findings on users' kernels that break their contracts."""
    # Derivatives are compared with differences, compiled with plain Python, forces of two bodies with each other.
    # flexmb's own kernels are left to its tests: with extreme numbers differences fail by round-off alone. Parts in
    # `known` have a finding and are left out.
    findings: list[Finding] = []
    bare = Mechanism(mechanism.name, mechanism.parts)
    seen: set[object] = set()
    for part in mechanism.parts:
        for contribution, light in zip(part.contributions(mechanism), part.contributions(bare), strict=True):
            kernels = kernels_of(contribution)
            key = tuple(kernel.name for kernel in kernels), contribution.p
            if key in seen or part.name in known or all(map(is_ours, kernels)):
                continue
            seen.add(key)
            try:
                check_piece(Bench(mechanism, part, 0), contribution, light)
            except KernelError as error:
                remedy = "testing.check_part(mechanism, name) checks it again after a change."
                findings.append(found("broken-kernel", (part.name,), str(error), remedy))
                break
    return findings


def kernels_of(contribution: Contribution) -> list[Kernel]:
    """All kernels that a contribution calls."""
    if isinstance(contribution, ContactContribution):
        return [contribution.gap, contribution.normal.kernel, contribution.friction.kernel]
    if isinstance(contribution, AngleContribution):
        return []
    kernels = [contribution.kernel]
    if isinstance(contribution, ElementContribution):
        kernels += [kernel for kernel in (contribution.energy, *contribution.short_ways) if kernel is not None]
    motions = getattr(contribution, "motions", ())
    friction = getattr(contribution, "joint_friction", None)
    return [*kernels, *(row.motion.kernel for row in motions), *([friction.friction.kernel] if friction else [])]


def is_ours(kernel: Kernel) -> bool:
    """Whether a kernel belongs to flexmb."""
    return kernel.function.__module__.partition(".")[0] == "flexmb"
