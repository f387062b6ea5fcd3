"""Fields along flexible bodies at the start: three numbers at every node."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import cast

from flexmb import checks
from flexmb.bodies.rigid_body import checked_velocity
from flexmb.errors import InputError

Triple = tuple[float, float, float]
Field = tuple[Triple, ...]
FieldLike = Sequence[Triple] | Callable[[float], Triple]

VELOCITY = ("(vx, vy, omega)", ("m/s", "m/s", "rad/s"))
DISPLACEMENT = ("(dx, dy, dtheta)", ("m", "m", "rad"))


def start_velocity(label: str, given: object, nodes: int, places: Sequence[float] | None) -> Triple | Field | None:
    """A start velocity: None, one triple for a rigid motion, or a field with one triple a node.

    `places` are the fractions of the length where the nodes stand, at which a function is evaluated; None: functions
    are refused.
    """
    if given is None:
        return None
    if not callable(given) and isinstance(given, Iterable) and not isinstance(given, str):
        given = checks.sequence(label, "velocity", given, f"{VELOCITY[0]}, or one triple")
        if not any(isinstance(item, Iterable) for item in given):
            return checked_velocity(label, given)
    elif not callable(given):
        return checked_velocity(label, given)
    return field(label, "velocity", given, nodes, places, *VELOCITY)


def start_displacement(label: str, given: object, nodes: int, places: Sequence[float] | None) -> Field | None:
    """A start displacement: None, or a field with one triple a node; `places` as in `start_velocity`."""
    return None if given is None else field(label, "displacement", given, nodes, places, *DISPLACEMENT)


def field(
    label: str, name: str, given: object, nodes: int, places: Sequence[float] | None, form: str, units: Sequence[str]
) -> Field:
    """One checked triple a node, from a list or a function of the place."""
    if callable(given):
        if places is None:
            raise InputError(
                f"{label}: {name} is a function, but a frame has no coordinate along it. "
                f"Give one {form} per node, {nodes} in all, in the order of its nodes."
            )
        function = cast("Callable[[float], object]", given)
        given = tuple(function(s) for s in places)
        whence = "the function returns {!r} at s = {:g}"
    else:
        given = checks.sequence(label, name, given, f"{form}, one per node")
        whence = ""
    if len(given) != nodes:
        raise InputError(
            f"{label}: {name} has {len(given)} entries, but the body has {nodes} nodes. Give one {form} per node"
            + (", or a function of s, 0 at the start and 1 at the end." if places is not None else ".")
        )
    found = []
    for i, item in enumerate(given):
        values = tuple(item) if isinstance(item, Iterable) and not isinstance(item, str) else (item,)
        if len(values) != 3:
            wrong = whence.format(item, (places or ())[i]) if whence else f"entry {i} is {item!r}"
            raise InputError(f"{label}: {name}: {wrong}; it must be {form}.")
        found.append(tuple(checks.number(label, f"{name}[{i}][{k}]", values[k], units[k]) for k in range(3)))
    return cast("Field", tuple(found))
