"""The nine-bar with 0.5 mm of play over ten turns after the first, in both codes: is it the same motion?

Single impacts are not comparable, since the motion is chaotic; means over turns are.  Long: some minutes.
"""

import itertools
import time

import models as m
import numpy as np
import peer_nine_bar
from duel import keep
from rows import contact_statistics, nine_bar_steppings, our_statistics

import flexmb as fm

TURNS = 10


def of_turns(found: list[dict[str, float]]) -> dict[str, list[float]]:
    """Mean and standard deviation of each value over the turns."""
    return {
        name: [float(np.mean([f[name] for f in found])), float(np.std([f[name] for f in found], ddof=1))]
        for name in found[0]
    }


def ours(*, flexible: bool) -> dict:
    """The default settings, turn by turn."""
    mech, state, found = m.nine_bar(flexible=flexible), None, []
    began = time.process_time()
    for turn in range(1, TURNS + 2):
        sol = fm.simulate(mech, t_end=turn * m.NINE_BAR_TURN, save="steps", restart=state)
        if not sol.ok:
            raise RuntimeError(sol.status)
        state = sol.restart
        found.append(our_statistics(sol))
    took = (time.process_time() - began) / (TURNS + 1)
    return {"code": "flexmb", "label": "default", "seconds a turn": took, "values": of_turns(found[1:])}


def theirs(label: str, stepping, *, flexible: bool) -> dict:
    """One run of the peer, cut into turns."""
    system = peer_nine_bar.nine_bar(flexible=flexible)
    turns = TURNS + 1
    chosen = type(stepping)(**{**vars(stepping), "steps": turns * stepping.steps})
    took, _ = system.solve(turns * m.NINE_BAR_TURN, chosen, watched=True)
    force, torque = system.record("force"), system.record("torque1")[:, 1]
    t, size = force[:, 0], np.linalg.norm(force[:, 1:3], axis=1)
    edges = np.searchsorted(t, np.arange(1, turns + 1) * m.NINE_BAR_TURN - 1e-9)
    found = [contact_statistics(t[a : b + 1], size[a : b + 1], torque[a : b + 1]) for a, b in itertools.pairwise(edges)]
    return {"code": "Exudyn", "label": label, "seconds a turn": took / turns, "values": of_turns(found)}


def measured(*, flexible: bool) -> dict:
    """All settings of the speed row but the slowest one with beams; the record is kept in out/speed."""
    rows = [ours(flexible=flexible)]
    steppings = nine_bar_steppings(flexible=flexible)
    rows += [theirs(label, how, flexible=flexible) for label, how in steppings.items() if label != "h = 5e-6"]
    name = "statistics-flexible" if flexible else "statistics-rigid"
    record = {"name": name, "turns": TURNS, "rows": rows}
    keep(name, record)
    return record
