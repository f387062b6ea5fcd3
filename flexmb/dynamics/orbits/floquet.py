"""Multipliers of a periodic orbit: stable or not, and how stability would be lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

REAL = 1e-9
"""Multipliers whose imaginary part is below this part of their size, or of 1, are real."""

FOLD, FLIP, NEIMARK_SACKER, GRAZING, BRANCH = "fold", "flip", "neimark-sacker", "grazing", "branch"

NEAR = 0.05
"""Turning points of a gap within this part of its travel from 0 are near to grazing."""


@dataclass(frozen=True)
class Loss:
    """How near an orbit is to a change of its stability, and of which kind.

    Parameters
    ----------
    kind : "fold": a multiplier near +1; "flip": near -1, where a doubled orbit begins; "neimark-sacker": a pair near
        the circle, where a torus begins; "grazing": surfaces that just touch or just miss each other; "none": an orbit
        without multipliers.
    margin : 1 less the size of that multiplier, < 0 beyond the change; of grazing the least distance as a part of the
        travel of the gap, < 0 where the surfaces touch.
    multiplier : the multiplier; NaN for grazing.
    """

    kind: str
    margin: float
    multiplier: complex


def multipliers_of(monodromy: np.ndarray, *, autonomous: bool) -> tuple[np.ndarray, complex | None]:
    """Eigenvalues, largest first, and the one taken from them that belongs to a shift in time (None: driven)."""
    found = np.linalg.eigvals(monodromy).astype(np.complex128)
    found = found[np.argsort(-np.abs(found), kind="stable")]
    if not autonomous or len(found) == 0:
        return found, None
    k = int(np.abs(found - 1.0).argmin())
    return np.delete(found, k), complex(found[k])


def is_real(multipliers: np.ndarray) -> np.ndarray:
    """Which of them are real."""
    return np.asarray(np.abs(multipliers.imag) <= REAL * np.maximum(np.abs(multipliers), 1.0))


def nearest_loss(multipliers: np.ndarray, graze: float | None) -> Loss:
    """The multiplier that is the nearest to the circle, by its factor; or grazing, if that is nearer."""
    if len(multipliers) == 0:
        return Loss("none", np.nan, complex(np.nan)) if graze is None else Loss(GRAZING, graze, complex(np.nan))
    k = int(np.abs(np.log(np.maximum(np.abs(multipliers), 1e-300))).argmin())
    critical = complex(multipliers[k])
    margin = 1.0 - abs(critical)
    if graze is not None and abs(graze) < min(abs(margin), NEAR):
        return Loss(GRAZING, graze, complex(np.nan))
    if not is_real(multipliers)[k]:
        return Loss(NEIMARK_SACKER, margin, critical)
    return Loss(FOLD if critical.real > 0.0 else FLIP, margin, critical)


def flip_test(multipliers: np.ndarray) -> float:
    """Changes its sign where a real multiplier passes -1; near it the distance to -1."""
    if len(multipliers) == 0:
        return 1.0
    below = int(np.sum(is_real(multipliers) & (multipliers.real < -1.0)))
    return float((-1.0) ** below * np.abs(multipliers + 1.0).min())


def torus_test(multipliers: np.ndarray) -> float:
    """Changes its sign where the product of two multipliers passes 1; near it the distance from 1.

    So it does where a pair crosses the circle, and where two real ones are each other's inverse, which is no change of
    stability (Y. A. Kuznetsov, Elements of Applied Bifurcation Theory, 1995, section 10.2).
    """
    n = len(multipliers)
    i, j = np.triu_indices(n, 1)
    if n < 2:
        return 1.0
    products = multipliers[i] * multipliers[j] - 1.0
    real = products.real[np.abs(products.imag) <= REAL * np.maximum(np.abs(products), 1.0)]
    # the others come in conjugate pairs, whose product is positive
    return float((-1.0) ** int(np.sum(real < 0.0)) * np.abs(products).min())


def crosses_circle(multipliers: np.ndarray) -> bool:
    """Whether it is a pair of complex multipliers whose product is nearest to 1."""
    turning = multipliers[~is_real(multipliers)]
    i, j = np.triu_indices(len(multipliers), 1)
    least = np.abs(multipliers[i] * multipliers[j] - 1.0).min(initial=np.inf)
    return bool(len(turning) and np.abs(np.abs(turning) ** 2 - 1.0).min() <= 1.01 * least + 1e-12)
