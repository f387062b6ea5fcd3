"""What contact laws say about a run when it has ended."""

from __future__ import annotations

import numpy as np

from flexmb.program.program import Program


def contact_remarks(program: Program, z: np.ndarray) -> tuple[str, ...]:
    """The remarks of all normal laws on their histories in `z`, each with the name of its joint and law."""
    found = []
    for contact, law, place in zip(program.names.contacts, program.normals, program.tables.contacts.z, strict=True):
        history = tuple(float(x) for x in z[place[1] : place[2]])
        label = f"{contact.partition('.')[0]} ({type(law).__name__})"
        found += [f"{label}: {text}." for text in law.remarks(history)]
    return tuple(found)
