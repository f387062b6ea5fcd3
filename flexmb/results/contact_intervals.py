"""Contact intervals ("episodes"): from onset to separation, one row each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from flexmb import checks, display
from flexmb.errors import InputError, UnknownNameError
from flexmb.fields import field, record_with
from flexmb.late import xr

COLUMNS = (  # names and units of the columns, in the order of the loop (`engine/step/contact_events.py`)
    ("contact", ""), ("mode", ""), ("end", "s"), ("separation_speed", "m/s"), ("start", "s"),
    ("approach_speed", "m/s"), ("impulse", "N s"), ("peak_force", "N"), ("peak_penetration", "m"),
    ("dissipated_contact", "J"), ("dissipated_friction", "J"),
)  # fmt: skip

COLUMN = {name: k for k, (name, _) in enumerate(COLUMNS)}
UNITS = {**dict(COLUMNS), "duration": "s", "flight": "s", "restitution": ""}
IMPACT, CONTINUOUS = 1, 2
MODES = {IMPACT: "impact", CONTINUOUS: "continuous"}
SHOWN_ROWS = 20  # number of rows of a printed table; further rows are left out in its middle


class ContactLog(NamedTuple):
    """Contact intervals of a run, as recorded by the loop."""

    names: tuple[str, ...] = ()  # the contacts, in the order of declaration
    # (n, 11) an episode each, in the order in which they ended, with the columns of `COLUMNS`; the contact is the
    # number of its name
    rows: np.ndarray = np.zeros((0, len(COLUMNS)))

    def columns(self, contact: int) -> dict[str, np.ndarray]:
        """Columns (n,) of the episodes of a contact, by name."""
        own = self.rows[self.rows[:, 0] == contact]
        return {name: own[:, k] for name, k in COLUMN.items()}

    def checked(self) -> ContactLog:
        """A checked copy with read-only rows, or `InputError`."""
        rows = np.array(self.rows, dtype=np.float64)
        if rows.ndim != 2 or rows.shape[1] != len(COLUMNS):
            raise InputError(f"Solution: contacts.rows has shape {rows.shape}; it must have shape (n, {len(COLUMNS)}).")
        numbers = rows[:, 0]
        if not np.all((numbers >= 0.0) & (numbers < len(self.names)) & (numbers == np.floor(numbers))):
            raise InputError(f"Solution: contacts.rows names a contact beyond the {len(self.names)} of contacts.names.")
        rows.flags.writeable = False
        return ContactLog(tuple(self.names), rows)


class UnknownContactError(InputError, UnknownNameError):
    """A name that is no contact of a solution; also a `KeyError`."""


@record_with(kw_only=True)
class Episode(display.Shown):
    """One contact interval; see `Episodes` for the fields."""

    contact: str = field("name of the contact")
    mode: int = field("1 impact, 2 continuous contact")
    start: float = field("begin", "s")
    end: float = field("end", "s")
    approach_speed: float = field("speed of the surfaces at the begin, along the normal, >= 0", "m/s")
    separation_speed: float = field("speed of the surfaces at the end, along the normal, >= 0", "m/s")
    impulse: float = field("impulse of the normal force", "N s")
    peak_force: float = field("largest normal force", "N")
    peak_penetration: float = field("largest depth", "m")
    dissipated_contact: float = field("energy lost in the normal direction", "J")
    dissipated_friction: float = field("energy lost in friction", "J")

    @property
    def duration(self) -> float:
        """Time in contact [s]."""
        return self.end - self.start

    @property
    def restitution(self) -> float:
        """Separation speed over approach speed [1]."""
        return self.separation_speed / self.approach_speed if self.approach_speed else float("nan")


@record_with(eq=False, kw_only=True, repr=False)
class Episodes:
    """Episodes of contact in the order of their starts; arrays by name, `[k]` one episode, `[mask]` some of them.

    An episode lasts from the instant where the gap falls through zero to that where it rises through zero.

    Raises
    ------
    InputError : arrays of different lengths.

    Notes
    -----
    Instants and speeds come from the cubic through gap and gap rate at the ends of the step, so they have the order of
    the integration.  Peaks are those of the accepted steps, as in `sol.peak`.  Impulses and losses are
    integrated as the account of the energy is, and add up to its `energy.dissipated_contact`.
    An episode that ran when saving began is whole, so its start lies before.  One that runs when the run ends
    holds what was collected so far, and whole it is in the solution that goes on from `restart`.
    Contacts shorter than a step, between two states that are both open or both closed, are not seen.

    Examples
    --------
    >>> import flexmb as fm
    >>> pin = fm.RigidBody("pin", at=(0.0, 0.0), mass=1.0, inertia=1.0, velocity=(1.0, 0.0, 0.0))
    >>> law = fm.LankaraniNikravesh(stiffness=1e9, restitution=0.9)
    >>> size = {"at": (0.0, 0.0), "clearance": 1e-3, "bearing_radius": 0.1}
    >>> mech = fm.Mechanism("thrown", [pin, fm.RevoluteClearance("J", fm.GROUND, pin, normal=law, **size)])
    >>> hits = fm.simulate(mech, t_end=0.005, step=1e-6).episodes("J")
    >>> hits.contact.tolist(), hits.approach_speed.round(3).tolist(), hits.impulse.round(3).tolist()
    (['J', 'J'], [1.0, 0.913], [1.913, 1.747])
    """

    name: str = field('what was asked for: a joint, one of its contacts, or "" for all')
    contact: np.ndarray = field("(n,) names of the contacts")
    mode: np.ndarray = field(
        "(n,) 1 for an impact: the bodies part after the first rebound; 2 for continuous contact: they are pressed "
        "together again before they part; the last value that the signal `mode` had in the episode"
    )
    start: np.ndarray = field("(n,) begins, located inside their steps; NaN: touched when the run began", "s")
    end: np.ndarray = field("(n,) ends, located inside their steps; NaN: touched when the run ended", "s")
    approach_speed: np.ndarray = field("(n,) speeds at the begins along the normal, >= 0; NaN as `start`", "m/s")
    separation_speed: np.ndarray = field("(n,) speeds at the ends along the normal, >= 0; NaN as `end`", "m/s")
    impulse: np.ndarray = field("(n,) integral of the normal force over time", "N s")
    peak_force: np.ndarray = field("(n,) largest values at accepted steps", "N")
    peak_penetration: np.ndarray = field("(n,) largest values at accepted steps", "m")
    dissipated_contact: np.ndarray = field("(n,) energy lost along the normal", "J")
    dissipated_friction: np.ndarray = field("(n,) energy lost by friction", "J")

    def __post_init__(self) -> None:
        for key in ARRAYS:
            array = np.array(getattr(self, key))
            if array.shape != (len(self.contact),):
                n = len(self.contact)
                raise InputError(f"Episodes {self.name!r}: {key} has shape {array.shape}; it must have shape ({n},).")
            array.flags.writeable = False
            object.__setattr__(self, key, array)

    def __len__(self) -> int:
        return len(self.contact)

    def __getitem__(self, which: Any) -> Any:
        """The `Episode` of that number, or the `Episodes` of a slice, a mask or an array of numbers."""
        if isinstance(which, (int, np.integer)):
            return Episode(**{key: getattr(self, key)[which].item() for key in ARRAYS})
        return Episodes(name=self.name, **{key: getattr(self, key)[which] for key in ARRAYS})

    def __iter__(self) -> Iterator[Episode]:
        return (self[k] for k in range(len(self)))

    @property
    def duration(self) -> np.ndarray:
        """(n,) times in contact [s]; NaN where start or end is."""
        return np.asarray(self.end - self.start)

    @property
    def restitution(self) -> np.ndarray:
        """(n,) separation speed over approach speed [1]; NaN for an episode that began without one."""
        return self.separation_speed / np.where(self.approach_speed > 0.0, self.approach_speed, np.nan)

    @property
    def flight(self) -> np.ndarray:
        """(n,) time before the episode in which none of these contacts touched [s]; NaN for the first one.

        It is 0 where another one is still running, as in a joint with several contacts.
        """
        ends = np.where(np.isnan(self.end), np.inf, self.end)
        last = np.concatenate([[np.nan], np.maximum.accumulate(ends)[:-1]])[: len(self)]
        return np.where(last > self.start, 0.0, self.start - last)

    def to_dataset(self) -> xr.Dataset:
        """All arrays over `episode`, with units."""
        columns = {key: xr.Variable("episode", getattr(self, key), {"units": UNITS[key]}) for key in QUANTITIES}
        flags = {"flag_values": list(MODES), "flag_meanings": " ".join(MODES.values())}
        contact = xr.Variable("episode", self.contact.astype(str))
        names = {"contact": contact, "mode": xr.Variable("episode", self.mode, flags)}
        return xr.Dataset({**names, **columns}, attrs={"name": self.name})

    def __repr__(self) -> str:
        what = f" of {self.name!r}" if self.name else ""
        head = f"{len(self)} episode{'' if len(self) == 1 else 's'} of contact{what}"
        if not len(self):
            return head
        keep = len(self) if len(self) <= SHOWN_ROWS else SHOWN_ROWS // 2
        rows = [("contact", "mode", *TABLE_HEADS), ("", "", *(f"[{UNITS[key]}]" for key in TABLE_HEADS.values()))]
        rows += [self._row(k) for k in range(len(self)) if k < keep or k >= len(self) - keep]
        widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
        lines = ["  ".join(text.rjust(width) for text, width in zip(row, widths, strict=True)) for row in rows]
        if keep < len(self):
            lines.insert(2 + keep, f"... {len(self) - 2 * keep} more")
        return "\n".join([head, *lines])

    def _repr_html_(self) -> str:
        units = (f"{head} [{UNITS[key]}]" for head, key in TABLE_HEADS.items())
        rows = display.table(map(self._row, range(min(len(self), display.MOST_ROWS + 1))), ("contact", "mode", *units))
        return display.page(repr(self).partition("\n")[0], "", rows)

    def _row(self, k: int) -> tuple[str, ...]:
        numbers = (float(getattr(self, key)[k]) for key in TABLE_HEADS.values())
        return (str(self.contact[k]), MODES[int(self.mode[k])], *(f"{x:.6g}" for x in numbers))


ARRAYS = tuple(f.name for f in fields(Episodes) if f.name != "name")
QUANTITIES = ARRAYS[2:]
# Heads of the printed columns, with their fields.
TABLE_HEADS = {
    "start": "start", "end": "end", "approach": "approach_speed", "separation": "separation_speed",
    "impulse": "impulse", "force": "peak_force", "depth": "peak_penetration",
    "lost": "dissipated_contact", "friction": "dissipated_friction",
}  # fmt: skip


def select(log: ContactLog, solution: str, name: str | None) -> Episodes:
    """The episodes of a joint or contact `name`, or of all (None), sorted by their starts."""
    joints = [contact.partition(".")[0] for contact in log.names]
    chosen = [k for k, contact in enumerate(log.names) if name in (None, contact, joints[k])]
    if name is not None and not chosen:
        known = list(dict.fromkeys([*joints, *log.names]))
        hint = checks.did_you_mean(str(name), known) if known else "Nothing in it touches."
        raise UnknownContactError(f"Solution of {solution!r} has no contact {name!r}. {hint}")
    rows = log.rows[np.isin(log.rows[:, 0], chosen)]
    column = {key: rows[:, i] for i, (key, _) in enumerate(COLUMNS)}
    order = np.argsort(np.nan_to_num(column["start"], nan=-np.inf), kind="stable")
    names = np.array(log.names, dtype=str)[column["contact"].astype(np.int64)]
    whole = {**column, "contact": names, "mode": column["mode"].astype(np.int64)}
    return Episodes(name=name or "", **{key: whole[key][order] for key in ARRAYS})


def impacts(episodes: Episodes) -> str:
    """Number of impacts, longest free flight, largest impulse of an impact."""
    hits = episodes[episodes.mode == IMPACT]
    lasting, text = len(episodes) - len(hits), f"{len(hits)}"
    if lasting:
        text += f" and {display.counted(lasting, 'continuous contact')}"
    if len(hits):
        text += f", largest impulse {hits.impulse.max():.3g} N s"
    flights = episodes.flight[np.isfinite(episodes.flight)]
    if len(flights):
        text += f", longest flight {flights.max():.3g} s"
    return text
