"""Contact and friction laws, and kernels: signs, derivatives, contracts."""

from __future__ import annotations

from collections.abc import Container

import numpy as np

from flexmb.doctor.finding import Finding, found
from flexmb.doctor.motions import values_of
from flexmb.errors import KernelError
from flexmb.kernels import Kernel
from flexmb.model.contributions import (
    AngleContribution,
    ContactContribution,
    Contribution,
    ElementContribution,
)
from flexmb.model.law import FrictionLaw, NormalLaw
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import Body, Part
from flexmb.testing.bench import Bench
from flexmb.testing.part import check_piece

SPEEDS = (-3.0, -0.1, -1e-3, 0.0, 1e-3, 0.1, 3.0)
"""Gap rates of the tries [m/s]."""

FAST_SLIPS = (-10.0, 10.0)
"""Slips at which friction must brake [m/s]; the friction of a belt may drive at slower ones."""

DEPTHS = (0.01, 0.3, 1.0)
"""Gaps and penetrations of the tries, relative to the clearance."""

LOADS = (1.0, 100.0)
"""Normal forces of the tries [N]."""

SMALL_GAP = 1e-4
"""Gap of the tries where the clearance is 0 [m]."""


def law_findings(mechanism: Mechanism) -> list[Finding]:
    """Findings on the signs of all contact and friction laws of a mechanism."""
    findings: list[Finding] = []
    for part in mechanism.parts:
        for contribution in () if isinstance(part, Body) else contacts_of(part, mechanism):
            gap = abs(contribution.p[0]) or SMALL_GAP
            findings += normal_sign(part.name, contribution.normal, gap)
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
            if N != 0.0 and not np.isnan(N):  # what is not a number is told by `kernel_findings`
                text = f"The normal law of {name!r} gives N = {N:.4g} N at a gap of {depth * gap:.4g} m"
                return [_pulls(name, f"{text} (gap rate {rate:g} m/s), where the surfaces are apart.")]
            N = float(values_of(law.kernel, p, h, -depth * gap, rate, z_new.copy(), np.zeros_like(z))[0])
            if N < 0.0:
                text = f"The normal law of {name!r} gives N = {N:.4g} N at a penetration of {depth * gap:.4g} m"
                return [_pulls(name, f"{text} (gap rate {rate:g} m/s); a contact can only push.")]
    return []


def _pulls(name: str, text: str) -> Finding:
    return found("pulling-contact", (name,), text, "Return 0 where the gap is positive, and never less than 0.")


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
    """Findings on users' kernels that break their contracts.

    Derivatives are compared with differences, compiled with plain Python, forces of two bodies with each other.
    flexmb's own kernels are left to its tests: with extreme numbers differences fail by round-off alone.  Parts in
    `known` have a finding and are left out.
    """
    findings: list[Finding] = []
    bare = Mechanism(mechanism.name, mechanism.parts)
    seen: set[object] = set()
    for part in mechanism.parts:
        for contribution, light in zip(part.contributions(mechanism), part.contributions(bare), strict=True):
            key = signature_of(contribution)
            if key in seen or part.name in known:
                continue
            seen.add(key)
            if all(is_ours(kernel) for kernel in kernels_of(contribution)):
                continue
            try:
                check_piece(Bench(mechanism, part, 0), contribution, light)
            except KernelError as error:
                remedy = "testing.check_part(mechanism, name) checks it again after a change."
                findings.append(found("broken-kernel", (part.name,), str(error), remedy))
                break
    return findings


def signature_of(contribution: Contribution) -> object:
    """Kernels of a contribution; and its parameters where a kernel is not flexmb's own."""
    kernels = kernels_of(contribution)
    if all(is_ours(kernel) for kernel in kernels):
        return tuple(kernel.name for kernel in kernels)
    return tuple(kernel.name for kernel in kernels), contribution.p


def kernels_of(contribution: Contribution) -> list[Kernel]:
    """All kernels that a contribution calls."""
    if isinstance(contribution, ContactContribution):
        return [contribution.gap, contribution.normal.kernel, contribution.friction.kernel]
    if isinstance(contribution, AngleContribution):
        return []
    kernels = [contribution.kernel]
    if isinstance(contribution, ElementContribution):
        more = (contribution.energy, contribution.force, contribution.tangent, contribution.account)
        kernels += [kernel for kernel in more if kernel is not None]
    motions = getattr(contribution, "motions", ())
    friction = getattr(contribution, "joint_friction", None)
    return [*kernels, *(row.motion.kernel for row in motions), *([friction.friction.kernel] if friction else [])]


def is_ours(kernel: Kernel) -> bool:
    """Whether a kernel belongs to flexmb."""
    return kernel.function.__module__.partition(".")[0] == "flexmb"
