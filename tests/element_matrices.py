"""Matrices of the elements of one straight beam, as bodies assemble those of all their beams at once."""

import numpy as np

from flexmb.elastic.beams.fem import BeamData, BeamMatrices, assembled


def beam_matrices(stations, section, material, *, rotary_inertia=False, shear=False) -> BeamMatrices:
    """Matrices of all elements between increasing stations (n + 1,) [m]; see `BeamData`."""
    return assembled([BeamData(np.array(stations, dtype=float), section, material, rotary_inertia, shear)])[0]


def mass_moments(matrices: BeamMatrices) -> tuple[float, float, float]:
    """Mass [kg], first moment [kg m] and inertia [kg m^2] about the start, by the exact motions w = 1 and w = x."""
    start = np.cumsum(matrices.lengths) - matrices.lengths
    zero, one = np.zeros_like(start), np.ones_like(start)
    shift = np.stack([one, zero, one, zero], axis=1)
    turn = np.stack([start, one, start + matrices.lengths, one], axis=1)
    pairs = ((shift, shift), (shift, turn), (turn, turn))
    mass, first, second = (float(np.einsum("ei,eij,ej->", a, matrices.bending_mass, b)) for a, b in pairs)
    return mass, first, second
