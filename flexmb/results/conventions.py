"""Names, units and global attributes of netCDF files by the CF conventions (https://cfconventions.org, CF-1.11)."""

from __future__ import annotations

import os
import platform
import shlex
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Any

from flexmb.version import installed_version

CONVENTIONS = "CF-1.11"
WRITERS = ("numpy", "h5py")
"""Packages whose versions a file tells, beside flexmb and Python."""

MEANINGS = {
    "x": "coordinate x",
    "y": "coordinate y",
    "theta": "rotation",
    "vx": "velocity along x",
    "vy": "velocity along y",
    "omega": "angular velocity",
    "ax": "acceleration along x",
    "ay": "acceleration along y",
    "alpha": "angular acceleration",
    "ex": "eccentricity along x",
    "ey": "eccentricity along y",
    "vex": "rate of the eccentricity along x",
    "vey": "rate of the eccentricity along y",
    "fx": "force along x",
    "fy": "force along y",
    "dx": "deflection along x",
    "dy": "deflection along y",
    "mode": "state of the contact",
}
"""Long names of signals whose own names are letters; docs/conventions.md defines them."""

ENERGIES = {
    "kinetic": "kinetic energy",
    "strain": "strain energy",
    "gravity": "potential energy of gravity",
    "drive_work": "work of the drives",
    "load_work": "work of the loads",
    "dissipated_contact": "energy lost in normal contact",
    "dissipated_friction": "energy lost by friction",
    "dissipated_damping": "energy lost by damping",
    "dissipated_algorithm": "energy lost by the time integration",
    "residual": "error of the balance of energies",
    "turned_over": "energy turned over",
}
"""Long names of the signals of the part `energy`."""


def long_name(signal: str) -> str:
    """Long name of a signal: "velocity along x of rod node3" for "rod.node3.vx"."""
    owner, _, own = signal.rpartition(".")
    if owner == "energy" and own in ENERGIES:
        return ENERGIES[own]
    meaning = MEANINGS.get(own, own.replace("_", " "))
    return f"{meaning} of {owner.replace('.', ' ')}" if owner else meaning


def udunits(unit: str) -> str:
    """Unit as UDUNITS reads it: "1" for a number without unit, "1/s" for "/s"; others, such as "N m", are the same."""
    plain = unit.strip()
    return f"1{plain}" if plain.startswith("/") else plain or "1"


def flag_meanings(names: tuple[str, ...]) -> str:
    """Names as the words of the attribute `flag_meanings`, without blanks inside a name."""
    return " ".join("_".join(name.split()) for name in names)


def global_attributes(model: Mapping[str, Any]) -> dict[str, str]:
    """Conventions, title, source, history and versions of a file that is written now.

    `model` has the name of the mechanism, the version of flexmb of the run, and the arguments of `flexmb run`.
    """
    now = datetime.now(UTC).isoformat(timespec="seconds")
    command = model.get("command")
    typed = shlex.join(["flexmb", *map(str, command)]) if isinstance(command, list) else "flexmb.Solution.to_netcdf"
    made = os.fsencode(typed).decode("utf-8", "replace")  # names of files need not be texts
    versions = [f"flexmb {installed_version()}", f"Python {platform.python_version()}"]
    return {
        "Conventions": CONVENTIONS,
        "title": f"Motion of the mechanism {model.get('name', '')!r}",
        "source": f"flexmb {model.get('flexmb', installed_version())}",
        "history": f"{now}: {made}",
        "versions": ", ".join([*versions, *(f"{package} {version(package)}" for package in WRITERS)]),
    }
