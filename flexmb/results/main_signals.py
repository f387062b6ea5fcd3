"""Main signals of a run: acceleration of the output body, and the signals with the largest peaks."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.joints.prismatic import Prismatic
from flexmb.model.mechanism import Mechanism
from flexmb.model.part import GROUND, Body
from flexmb.results.solution import Solution
from flexmb.results.solution_text import largest_signals

MOST = 16
"""Largest number of main signals."""
PANELS = 6
"""Largest number of panels of the picture."""
GUIDES = ("Prismatic", "PrismaticClearance")
"""Classes of joints whose second body is a slider."""


def followed(mechanism: Mechanism) -> Body | None:
    """The output body of a mechanism: the first slider, else the last body."""
    for part in mechanism.parts:
        if isinstance(part, Prismatic) and part.second.name != GROUND.name:
            return mechanism.body(part.second.name)
    return mechanism.bodies[-1] if mechanism.bodies else None


def main_signals(sol: Solution) -> list[str]:
    """Names of the main signals: acceleration of the output body, and the signals with the largest peaks.

    A solution without a description of its mechanism has no output body.
    """
    names = [name for name in _rates(sol.described().get("parts", [])) if name in sol]
    return list(dict.fromkeys([*names, *largest_signals(sol)]))[:MOST]


def _rates(parts: list[dict[str, Any]]) -> list[str]:
    """Acceleration signals of the output body: along the guide of a slider, angular for another body."""
    guides = [part["fields"] for part in parts if part["class"] in GUIDES]
    guide = next((fields for fields in guides if fields["second"][0] != GROUND.name), None)
    if guide is None:
        return [f"{part['name']}.alpha" for part in parts if part["kind"] == "body"][-1:]
    along = np.array(guide["along"][0])
    share = np.abs(along) / np.hypot(*along)
    return [f"{guide['second'][0]}.{axis}" for axis, s in zip(("ax", "ay"), share, strict=True) if s > 1e-6]


def panels(sol: Solution, names: list[str] | None = None) -> list[list[str]]:
    """Main signals by panel, one kind of signal per panel."""
    kinds: dict[tuple[str, str], list[str]] = {}
    for name in main_signals(sol) if names is None else names:
        kinds.setdefault((name.rpartition(".")[2], sol.units(name)), []).append(name)
    return list(kinds.values())[:PANELS]


def slides(mechanism: Mechanism, body: Body) -> Prismatic | None:
    """Prismatic joint of a sliding body; None for another body."""
    guides = (p for p in mechanism.parts if isinstance(p, Prismatic) and p.second.name == body.name)
    return next(guides, None)
