"""The rows of docs/performance.md: each model with the settings of both codes.  Needs the peer."""

import math
import multiprocessing
import time
from collections.abc import Callable
from functools import partial
from unittest import mock

import minimal
import models as m
import numpy as np
import peer
import peer_link
import peer_nine_bar
from duel import COUNTING, GaveUp, Row, Runner, Wish
from peer import BEAM_TOLERANCES, TRAPEZOIDAL, Stepping

import flexmb as fm

TWO_TURNS = 2.0 * m.TURN
FALL = 0.5  # s


def ours(label: str, mechanism: fm.Mechanism, values: Callable, t_end: float, **options) -> Runner:
    """flexmb with these options of `simulate`."""

    def once() -> float:
        with mock.patch("time.perf_counter", time.process_time):  # the clock that stats.wall_time is read from
            return _finished(mechanism, t_end=t_end, save=1, **options).stats.wall_time

    def looked_at() -> dict[str, float]:
        sol = _finished(mechanism, t_end=t_end, save="steps", **options)
        return {**values(sol), "steps": sol.stats.steps}

    return Runner("flexmb", label, once, looked_at)


def _finished(mechanism: fm.Mechanism, **options) -> fm.Solution:
    sol = fm.simulate(mechanism, **options)
    if not sol.ok:
        raise GaveUp(sol.status)
    return sol


def named(h: float) -> str:
    """Label of a fixed step."""
    return f"h = {h:.0e}".replace("e-0", "e-")


def theirs(label: str, build: Callable, values: Callable, t_end: float, stepping: Stepping) -> Runner:
    """The peer with this stepping."""

    def solved(*, watched: bool):
        system = build()
        try:
            return system, system.solve(t_end, stepping, watched=watched)
        except peer.PeerError as error:
            raise GaveUp(str(error)) from error

    def looked_at() -> dict[str, float]:
        system, (_, steps) = solved(watched=True)
        return {**values(system), "steps": steps}

    return Runner("Exudyn", label, lambda: solved(watched=False)[1][0], looked_at)


# Ideal slider-crank.


def _ideal_values(t, x, torque) -> dict[str, float]:
    """Against the exact torque; the first tenth is left out, where the start still swings."""
    kept = t > 0.1 * TWO_TURNS
    exact = m.ideal_torque(m.OMEGA * t)
    return {
        "error": float(np.abs(np.abs(torque) - np.abs(exact))[kept].max() / np.abs(exact).max()),
        "torque [N m]": float(np.abs(torque[kept]).max()),
        "place [m]": float(np.abs(x - m.ideal_position(m.OMEGA * t)).max()),
    }


def _ideal() -> list[Runner]:
    def our_values(sol):
        return _ideal_values(sol.time, sol.array("slider.x"), sol.array("motor.torque"))

    def their_values(system):
        x, torque = system.record("position"), system.record("torque")
        return _ideal_values(x[:, 0], x[:, 1], torque[:, 1])

    return [
        ours("h = 1e-5", m.ideal(), our_values, TWO_TURNS, step=1e-5),
        ours("default", m.ideal(), our_values, TWO_TURNS),
        theirs("h = 1e-5", peer.ideal, their_values, TWO_TURNS, Stepping(2400)),
        theirs("h = 1e-5, full Newton", peer.ideal, their_values, TWO_TURNS, Stepping(2400, full_newton=True)),
    ]


# Play between rod and slider.

PEAK = {0.0: 45872.23, 0.03: 45825.04}  # N; minimal.worn_reference, rtol 1e-12, contacts located by events
TORQUE = 985.58  # N m, the same, mu = 0.03
PLACE = 0.16097495  # m, slider at 1 ms, the same


def _worn_values(t, x, force, peak, torque) -> dict[str, float]:
    return {
        "error": abs(peak / PEAK[0.03] - 1.0),
        "peak [N]": peak,
        "first [s]": float(t[np.argmax(force > 0.0)]),
        "place [m]": float(abs(np.interp(1e-3, t, x) - PLACE)),
        "torque [N m]": torque,
    }


def _our_worn_values(sol) -> dict[str, float]:
    peaks = (sol.peak(name).value for name in ("C.normal_force", "motor.torque"))
    return _worn_values(sol.time, sol.array("slider.x"), sol.array("C.normal_force"), *peaks)


def _their_worn_values(system) -> dict[str, float]:
    x, force, torque = (system.record(name) for name in ("position", "force", "torque"))
    size = np.linalg.norm(force[:, 1:3], axis=1)
    return _worn_values(x[:, 0], x[:, 1], size, float(size.max()), float(np.abs(torque[:, 1]).max()))


ORDER_EIGHT = {
    named(rtol).replace("h", "rtol"): {"method": fm.DormandPrince(), "step": fm.Adaptive(rtol=rtol)}
    for rtol in (1e-2, 1e-3, 1e-4)
}


def _worn() -> list[Runner]:
    variants = {
        "h = 1e-5": Stepping(2400, "fixed"),
        "h = 2e-6": Stepping(12000, "fixed"),
        "h = 1.6e-6": Stepping(15000, "fixed"),
        "h = 1e-6": Stepping(24000, "fixed"),
        "located, index 3": Stepping(480, "located"),
        "located, index 2": Stepping(480, "located", TRAPEZOIDAL),
    }
    return [
        ours("default", m.worn(), _our_worn_values, TWO_TURNS),
        *(ours(f"order 8, {name}", m.worn(), _our_worn_values, TWO_TURNS, **how) for name, how in ORDER_EIGHT.items()),
        ours("h = 1e-5", m.worn(), _our_worn_values, TWO_TURNS, step=1e-5),
        ours("h = 1e-6", m.worn(), _our_worn_values, TWO_TURNS, step=1e-6),
        *(theirs(label, peer.worn, _their_worn_values, TWO_TURNS, how) for label, how in variants.items()),
    ]


def _user_law() -> list[Runner]:
    return [
        ours("h = 1e-5", m.user_law(), _our_worn_values, TWO_TURNS, step=1e-5),
        ours("default", m.user_law(), _our_worn_values, TWO_TURNS),
        theirs("h = 1e-5", peer.user_law, _their_worn_values, TWO_TURNS, Stepping(2400, "fixed")),
    ]


# Rod of beams.


def _deflection(begin, middle, end) -> np.ndarray:
    """Of the middle from the chord between the ends [m]."""
    chord, offset = end - begin, middle - begin
    return (chord[:, 0] * offset[:, 1] - chord[:, 1] * offset[:, 0]) / np.linalg.norm(chord, axis=1)


def _their_deflection(system) -> tuple[np.ndarray, np.ndarray]:
    t = system.record("middle")[:, 0]
    return t, _deflection(*(system.record(name)[:, 1:3] for name in ("begin", "middle", "end")))


GRID = np.linspace(0.0, TWO_TURNS, 601)
FINE = 5e-7  # s, step of the runs that are taken for converged in time


def _rod(section: str) -> list[Runner]:
    """Errors in time: each code against its own run with steps of FINE; in space both have eight cubic elements."""
    mech, build = m.flexible_rod(section), partial(peer.flexible_rod, section)

    def compared(fine, t, d):
        found = np.interp(GRID, t, d)
        rms = float(np.sqrt(np.mean((found - fine) ** 2)) / np.abs(fine).max())
        return {"error": rms, "deflection [um]": float(1e6 * np.abs(d).max())}

    sol = _finished(mech, t_end=TWO_TURNS, step=FINE, save=600)
    own = np.interp(GRID, sol.time, sol.array("rod.deflection"))
    system = build()
    system.solve(TWO_TURNS, Stepping(round(TWO_TURNS / FINE), sparse=True), watched=True)
    their_own = np.interp(GRID, *_their_deflection(system))
    sides = float(np.sign(own @ their_own))

    def our_values(sol):
        return compared(own, sol.time, sol.array("rod.deflection"))

    def their_values(system):
        t, d = _their_deflection(system)
        apart = float(np.sqrt(np.mean((their_own - sides * own) ** 2)) / np.abs(own).max())
        return {**compared(their_own, t, d), "converged, apart": apart}

    variants = {
        "h = 2e-5, sparse": Stepping(1200, sparse=True),
        "h = 1e-5, sparse": Stepping(2400, sparse=True),
        "h = 1e-5, dense": Stepping(2400),
        "h = 5e-6, sparse": Stepping(4800, sparse=True),
    }
    return [
        *(ours(named(h), mech, our_values, TWO_TURNS, step=h) for h in (2e-5, 1e-5, 5e-6)),
        ours("default", mech, our_values, TWO_TURNS),
        *(theirs(label, build, their_values, TWO_TURNS, how) for label, how in variants.items()),
    ]


# Rod that is a reduced plane link.


def _link_deflection(t: np.ndarray, middle: np.ndarray, slider: np.ndarray) -> np.ndarray:
    """Of the link's middle from the chord between its eyes, of which the crank carries the first one [m]."""
    begin = m.CRANK * np.stack([np.cos(m.OMEGA * t), np.sin(m.OMEGA * t)], axis=1)
    return _deflection(begin, middle, np.stack([slider, 0.0 * slider], axis=1))


def _link(modes: int) -> list[Runner]:
    """Errors in time: each code against its own run with steps of FINE; both keep as many modes in the plane."""
    mech, build = m.link_rod(modes), partial(peer_link.slider_crank, modes)
    own_modes = mech.find("rod").frequencies(2).tolist()
    their_modes = peer_link.frequencies(modes, 2).tolist()

    def our_deflection(sol):
        at = sol.positions("rod", [(m.CRANK + 0.5 * m.ROD, 0.0)]).isel(place=0)
        middle = np.stack([at["x"].values, at["y"].values], axis=1)
        return _link_deflection(sol.time, middle, sol.array("slider.x"))

    def their_deflection(system):
        middle, slider = system.record("middle"), system.record("slider")
        return middle[:, 0], _link_deflection(middle[:, 0], middle[:, 1:3], slider[:, 1])

    def compared(fine, t, d):
        found = np.interp(GRID, t, d)
        rms = float(np.sqrt(np.mean((found - fine) ** 2)) / np.abs(fine).max())
        return {"error": rms, "deflection [um]": float(1e6 * np.abs(d).max())}

    sol = _finished(mech, t_end=TWO_TURNS, step=FINE, save=600)
    own = np.interp(GRID, sol.time, our_deflection(sol))
    system = build()
    system.solve(TWO_TURNS, Stepping(round(TWO_TURNS / FINE)), watched=True)
    their_own = np.interp(GRID, *their_deflection(system))

    def our_values(sol):
        first = {f"f{k + 1} [Hz]": f for k, f in enumerate(own_modes)}
        return {**compared(own, sol.time, our_deflection(sol)), **first}

    def their_values(system):
        apart = float(np.sqrt(np.mean((their_own - own) ** 2)) / np.abs(own).max())
        first = {f"f{k + 1} [Hz]": f for k, f in enumerate(their_modes)}
        return {**compared(their_own, *their_deflection(system)), **first, "converged, apart": apart}

    return [
        *(ours(named(h), mech, our_values, TWO_TURNS, step=h) for h in (2e-5, 1e-5, 5e-6)),
        ours("default", mech, our_values, TWO_TURNS),
        theirs("h = 2e-5", build, their_values, TWO_TURNS, Stepping(1200)),
        theirs("h = 1e-5", build, their_values, TWO_TURNS, Stepping(2400)),
        theirs("h = 1e-5, coarser", build, their_values, TWO_TURNS, Stepping(2400, tolerances=BEAM_TOLERANCES)),
        theirs("h = 5e-6", build, their_values, TWO_TURNS, Stepping(4800)),
    ]


# Falling chain.

TIGHT = (1e-6, 1e-6)  # tolerances with which the peer's error is that of its steps, no longer of Newton's method

TIPS = {(9, 4): (3.08547173, -1.22543182), (9, 40): (3.08547173, -1.22543351), (90, 4): (35.78880529, -1.22624997)}
"""Tip after 0.5 s, converged in time [m]: steps of 5e-6 s (9 x 4) and 2e-5 s; both codes agree to 1e-8 m there."""


def _chain(links: int, elements: int, steps: tuple[float, ...]) -> list[Runner]:
    mech, build = m.chain(links, elements), partial(peer.chain, links, elements)

    def error(x, y):
        tip = TIPS[links, elements]
        return {"error": float(math.hypot(x - tip[0], y - tip[1])), "x [m]": float(x), "y [m]": float(y)}

    def our_values(sol):
        last = f"L{links - 1}.end"
        return error(sol.array(f"{last}.x")[-1], sol.array(f"{last}.y")[-1])

    def their_values(system):
        return error(*system.record("tip")[-1, 1:3])

    found = [ours(named(h), mech, our_values, FALL, step=h) for h in steps]
    found.append(ours("default", mech, our_values, FALL))
    for h in steps:
        how = Stepping(round(FALL / h), sparse=True, tolerances=BEAM_TOLERANCES)
        found.append(theirs(named(h), build, their_values, FALL, how))
    if (links, elements) == (9, 4):  # larger chains stall with these
        how = Stepping(round(FALL / 1e-4), sparse=True, tolerances=TIGHT)
        found.append(theirs("h = 1e-4, tighter", build, their_values, FALL, how))
    return found


# Nine-bar with 0.5 mm of play.


def contact_statistics(t, force, torque) -> dict[str, float]:
    """Mean and rms force, share of free flight, contacts a turn, rms torque, weighted by the steps."""
    dt, after = np.diff(t), force[1:]
    whole = dt.sum()
    return {
        "mean force [N]": float(after @ dt / whole),
        "rms force [N]": float(np.sqrt(after**2 @ dt / whole)),
        "flight": float(dt[after == 0.0].sum() / whole),
        "contacts a turn": float(((force[1:] > 0.0) & (force[:-1] == 0.0)).sum() * m.NINE_BAR_TURN / whole),
        "rms torque [N m]": float(np.sqrt(torque[1:] ** 2 @ dt / whole)),
        "peak force [N]": float(force.max()),
    }


def our_statistics(sol) -> dict[str, float]:
    return contact_statistics(sol.time, sol.array("P1.normal_force"), sol.array("motor1.torque"))


def their_statistics(system) -> dict[str, float]:
    force = system.record("force")
    return contact_statistics(force[:, 0], np.linalg.norm(force[:, 1:], axis=1), system.record("torque1")[:, 1])


def nine_bar_steppings(*, flexible: bool) -> dict[str, Stepping]:
    """The peer's settings for a turn; with beams the default tolerances of Newton's method cut steps and are slower."""
    options = {"sparse": True, "tolerances": BEAM_TOLERANCES} if flexible else {}
    steps = {"h = 1e-5": 100_000, "h = 5e-6": 200_000} if flexible else {"h = 2e-5": 50_000, "h = 1e-5": 100_000}
    found = {label: Stepping(n, "fixed", **options) for label, n in steps.items()}
    nominal = 10_000 if flexible else 5_000
    found["located, index 2"] = Stepping(nominal, "located", TRAPEZOIDAL, **options)
    return found


def _nine_bar(*, flexible: bool) -> list[Runner]:
    mech, build = m.nine_bar(flexible=flexible), partial(peer_nine_bar.nine_bar, flexible=flexible)
    steppings = nine_bar_steppings(flexible=flexible)
    turn = m.NINE_BAR_TURN
    return [
        ours("default", mech, our_statistics, turn),
        ours("h = 1e-5", mech, our_statistics, turn, step=1e-5),
        *(theirs(label, build, their_statistics, turn, how) for label, how in steppings.items()),
    ]


# Sweep of 16 clearances.

PLAYS = np.linspace(0.05e-3, 0.5e-3, 16).tolist()


def _our_point(clearance: float, step, **how) -> float:
    """Peak force of one point; the model is built and compiled here, the code is not."""
    return _finished(m.worn(0.0, clearance), t_end=TWO_TURNS, save=1, step=step, **how).peak("C.normal_force").value


def _their_point(clearance: float) -> int:
    return peer.worn(0.0, clearance).solve(TWO_TURNS, Stepping(2400, "fixed"))[1]


def _their_peak(clearance: float) -> float:
    system = peer.worn(0.0, clearance)
    system.solve(TWO_TURNS, Stepping(2400, "fixed"), watched=True)
    return float(np.linalg.norm(system.record("force")[:, 1:3], axis=1).max())


def _counted(_: float) -> int:
    """Some 10 ms of counting, which needs no memory: what two cores can gain."""
    return sum(k * k for k in range(250_000))


def swept(point: Callable, clock: Callable[[], float]) -> float:
    """Time of all points in one process [s], with building the models."""
    began = clock()
    for play in PLAYS:
        point(play)
    return clock() - began


def pooled(point: Callable, processes: int) -> tuple[float, float]:
    """Times by the clock [s]: of all points in a pool that runs and is warm, and of its start and its end."""
    clock = time.perf_counter
    begin = clock()
    pool = multiprocessing.get_context("fork").Pool(processes)
    pool.map(abs, range(processes), chunksize=1)
    ready = clock()
    pool.map(point, PLAYS[:processes], chunksize=1)
    warm = clock()
    for _ in pool.imap(point, PLAYS):
        pass
    done = clock()
    pool.close()
    pool.join()
    return done - warm, ready - begin + clock() - done


def _sweep() -> list[Runner]:
    """CPU times of one process; the clock's where one process is compared with two."""
    exact = [minimal.first_peak(play) for play in PLAYS]  # the first impact of a run is the hardest, in all 16

    def values(peak):
        missed = [abs(peak(play) / p - 1.0) for play, p in zip(PLAYS, exact, strict=True)]
        return {"error": float(np.median(missed)), WORST: float(np.quantile(missed, 0.9))}

    def values_and_pool(peak, point):
        return {**values(peak), "start and end [ms]": 1e3 * min(pooled(point, 2)[1] for _ in range(3))}

    settings = {"h = 1e-5": 1e-5, "default": None}
    settings |= {f"rtol = {label}": fm.Adaptive(rtol=float(label)) for label in ("1e-3", "3e-3", "1e-2", "2e-2")}
    points = {label: partial(_our_point, step=step) for label, step in settings.items()}
    points |= {f"order 8, {label}": partial(_our_point, **how) for label, how in ORDER_EIGHT.items()}
    default, cpu, clock = points["default"], time.process_time, time.perf_counter
    alone = [Runner("flexmb", label, partial(swept, p, cpu), partial(values, p)) for label, p in points.items()]
    return [
        *alone,
        Runner("Exudyn", "h = 1e-5", partial(swept, _their_point, cpu), partial(values, _their_peak)),
        Runner("flexmb", ONE, partial(swept, default, clock), partial(values, default)),
        Runner("flexmb", TWO, lambda: pooled(default, 2)[0], partial(values_and_pool, default, default)),
        Runner(COUNTING, ONE, partial(swept, _counted, clock), dict),
        Runner(COUNTING, TWO, lambda: pooled(_counted, 2)[0], dict),
        Runner("Exudyn", ONE, partial(swept, _their_point, clock), partial(values, _their_peak)),
        Runner("Exudyn", TWO, lambda: pooled(_their_point, 2)[0], partial(values_and_pool, _their_peak, _their_point)),
    ]


WORST = "error, 90 %"
ONE, TWO = "one process, by the clock", "two processes that run, by the clock"

SWEEP_NOTE = (
    "Times contain building and compiling the models. Two processes: a forked pool that runs and has done one point "
    "a process; its start and its end, which a sweep pays once, stand beside it. They compare only where both cores "
    "are free, which the load average tells: above 2 other work took its part. Both errors decide what is as "
    "accurate. Of a point with default settings some 2 ms are spent around the steps: 0.4 for building the parts, "
    "0.7 for the program, 0.3 for start values, 0.7 for arrays and the solution. The peer takes 39 ms a point in all."
)

WORN_NOTE = (
    "Torques above 1.05 times the reference are false peaks, in bold. place: error of the slider at 1 ms. Of our 2180 "
    "steps with default settings 260 are flight, 950 impacts, 950 lasting contact, where the error of positions bounds "
    "them; 161 trials are refused. A step takes 2.5 corrections, 1.7 matrices and 0.4 whole evaluations for the "
    "account of energies. In impacts the number of steps decides over the peak: 28 instead of 32 would save 5 % of the "
    "time with an error of 0.11 %, 24 would save 12 % with 0.18 %; neither was taken."
)

CHAIN_NOTE = (
    "Of our step of 19 us with 9 links of 4 beams 43 % are evaluations (3.4 a step, one of them with energies), 20 % "
    "solutions with the factors and 8 % what follows them (3.1 corrections), 15 % matrices and factors (0.5 a step), "
    "9 % outputs and largest values. Corrections converge linearly, since the factors are old and waves of the beams "
    "are not resolved; four times the peer's speed at the same step would take one correction less. The peer takes "
    "fewer, with the larger error that stands beside it."
)
ROD_NOTE = (
    "converged, apart: rms of the difference of what the two codes converge to, over the peak. A step "
    "of 8 us takes 3.3 corrections and one matrix with the heavy rod. Waves that the steps do not resolve make the "
    "first correction 1e5 times as large as what is wanted; two steps in five begin with the factors of the step "
    "before, one in three makes two matrices."
)

LINK_NOTE = (
    "The peer has no plane bodies: its link is the same mesh drawn out to a solid of one cell of 27 nodes across the "
    "thickness (`tests/speed/peer_link.py`), reduced with rigid eyes; modes that leave the plane are left out by hand, "
    "so that both codes keep the same number, and its markers take four nodes of an eye: with all of them its steps "
    "take many times as long. f1, f2: of the free link. 'coarser': tolerances of Newton's method of 1e-4 and 1e-2. "
    "Our time contains the search for the largest stress of each step, the peer's none. What the two converge to "
    "differs by a solid against plane stress, and by the stiffening by forces, which the peer leaves out. The peer "
    "reduces bodies of any shape in space, and reads matrices of Abaqus and Ansys; flexmb does neither."
)

SAME = "same step"
EQUAL = "at no larger an error"

ROWS = {
    row.name: row
    for row in (
        Row(
            "ideal",
            "ideal rigid slider-crank, 2 turns",
            "largest difference to the exact drive torque after the first tenth, over its peak",
            _ideal,
            (
                Wish("h = 1e-5", 4.0, "h = 1e-5", SAME),
                Wish("h = 1e-5, full Newton", 4.0, "h = 1e-5", SAME),
                Wish("h = 1e-5", 4.0, None, EQUAL),
            ),
            reference="exact: torque dE/dtheta, peak 138.522 N m; largest speed 28.4114 m/s",
            note="place: largest difference to the exact place of the slider.",
        ),
        Row(
            "worn",
            "slider-crank with 0.5 mm of play, mu = 0.03, 2 turns",
            "of the peak force, relative",
            _worn,
            tuple(
                Wish(label, 4.0, "default", "reaches 0.2 %")
                for label in ("h = 1.6e-6", "h = 1e-6", "located, index 3", "located, index 2")
            )
            + tuple(Wish(label, 6.0, None, EQUAL) for label in ("located, index 3", "located, index 2")),
            reference="minimal.py with rtol 1e-12: 45825 N, first contact 0.22729 ms, torque at most 985.6 N m",
            note=WORN_NOTE,
            ceiling=2e-3,
            spikes=1.05 * TORQUE,
        ),
        Row(
            "user-law",
            "the same with a user's law in Python, 2 turns",
            "of the peak force, relative",
            _user_law,
            (Wish("h = 1e-5", 8.0, "h = 1e-5", SAME), Wish("h = 1e-5", 8.0, None, EQUAL)),
            reference="as above",
        ),
        *(
            Row(
                f"rod-{section}",
                f"slider-crank with a {section} rod of 8 beams, 2 turns",
                "rms over the largest deflection, against the same code with steps of 5e-7 s",
                partial(_rod, section),
                (
                    Wish("h = 1e-5, sparse", 4.0, "h = 1e-5", SAME),
                    Wish("h = 5e-6, sparse", 4.0, None, EQUAL),
                ),
                reference=f"peak deflection {value} um with steps of 2e-6 s in either code",
                note=ROD_NOTE,
            )
            for section, value in (("heavy", "46.91"), ("slender", "408.8"))
        ),
        Row(
            "link",
            "slider-crank whose rod is a reduced link with eyes, 6 modes, 2 turns",
            "rms over the largest deflection, against the same code with steps of 5e-7 s",
            partial(_link, 6),
            (
                Wish("h = 1e-5", 4.0, "h = 1e-5", SAME),
                Wish("h = 5e-6", 4.0, None, EQUAL),
                Wish("h = 1e-5, coarser", 3.0, None, EQUAL),
            ),
            reference="mesh of all nodes: 3639.9 and 9551.6 Hz (`PlaneBody.frequencies`)",
            note=LINK_NOTE,
        ),
        *(
            Row(
                name,
                f"falling chain of {links} links of {elements} beams, 0.5 s",
                "distance of the tip at 0.5 s from where it converges to with smaller steps [m]",
                partial(_chain, links, elements, steps),
                wishes,
                reference=f"converged tip {TIPS[links, elements]} m",
                note=CHAIN_NOTE if (links, elements) == (9, 4) else "",
            )
            for name, links, elements, steps, wishes in (
                (
                    "chain",
                    9,
                    4,
                    (4e-4, 3e-4, 2e-4, 1e-4),
                    (
                        Wish("h = 1e-4", 4.0, "h = 1e-4", SAME),
                        Wish("h = 1e-4", 4.0, None, EQUAL),
                        Wish("h = 1e-4, tighter", 4.0, None, EQUAL),
                        Wish("h = 4e-4", 4.0, None, EQUAL),
                    ),
                ),
                (
                    "chain-9x40",
                    9,
                    40,
                    (2e-4, 1e-4),
                    (Wish("h = 1e-4", 4.0, "h = 1e-4", SAME), Wish("h = 1e-4", 4.0, None, EQUAL)),
                ),
                (
                    "chain-90x4",
                    90,
                    4,
                    (2e-4, 1e-4),
                    (Wish("h = 1e-4", 4.0, "h = 1e-4", SAME), Wish("h = 1e-4", 4.0, None, EQUAL)),
                ),
            )
        ),
        Row(
            "nine-bar",
            "rigid nine-bar, 0.5 mm of play, 2 pi rad/s, first turn",
            "none: chaotic; see the statistics",
            partial(_nine_bar, flexible=False),
            (
                Wish("h = 2e-5", 5.0, "default", "same statistics"),
                Wish("h = 1e-5", 5.0, "default", "same statistics"),
                Wish("located, index 2", 1.0, "default", "its fastest setting"),
            ),
        ),
        Row(
            "nine-bar-flexible",
            "the same with 4 beams a link, first turn",
            "none: chaotic; see the statistics",
            partial(_nine_bar, flexible=True),
            (
                Wish("h = 1e-5", 5.0, "default", "same statistics"),
                Wish("h = 5e-6", 5.0, "default", "same statistics"),
                Wish("located, index 2", 1.0, "default", "its fastest setting"),
            ),
        ),
        Row(
            "sweep",
            "16 clearances from 0.05 to 0.5 mm, mu = 0, 2 turns each",
            "of the peak force, relative, median of the 16; 90 %: nine in ten are smaller",
            _sweep,
            (
                Wish("h = 1e-5", 5.0, None, EQUAL),
                Wish("h = 1e-5", 5.0, "h = 1e-5", SAME),
                Wish("h = 1e-5", 5.0, "default", "more accurate"),
                Wish("h = 1e-5", 5.0, "rtol = 1e-3", "more accurate"),
                Wish("h = 1e-5", 5.0, "order 8, rtol = 1e-2", "more accurate"),
            ),
            note=SWEEP_NOTE,
            cores=(ONE, TWO, 1.9),
        ),
    )
}
