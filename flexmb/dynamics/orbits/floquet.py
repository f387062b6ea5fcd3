"""Floquet multipliers of a periodic orbit: stability, and the nearest loss of stability."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

REAL = 1e-9
"""Imaginary part, over the size of the multiplier or 1, below which a multiplier counts as real."""

FOLD, FLIP, NEIMARK_SACKER, GRAZING, BRANCH = "fold", "flip", "neimark-sacker", "grazing", "branch"
"""Kinds of changes of stability; a branch point is a crossing of two branches."""

NEAR = 0.05
"""Distance of a turning point of a gap from 0, over the travel of the gap, below which grazing is near."""


@dataclass(frozen=True)
class StabilityLoss:
    """The nearest loss of stability of an orbit.

    Parameters
    ----------
    kind : "fold": a multiplier near +1; "flip": a multiplier near -1, where a doubled orbit begins; "neimark-sacker": a
        pair near the unit circle, where a torus begins; "grazing": surfaces that just touch or just miss each other;
        "none": an orbit without multipliers.
    margin : 1 less the size of the multiplier, < 0 beyond the loss; for grazing the least gap over its travel, < 0 for
        surfaces in contact.
    multiplier : the multiplier; NaN for grazing.
    """

    kind: str
    margin: float
    multiplier: complex


def multipliers_of(monodromy: np.ndarray, *, autonomous: bool) -> tuple[np.ndarray, complex | None]:
    """Floquet multipliers, largest first, and the multiplier of a shift in time (None for a driven flow).

    The monodromy matrix (d, d) is the derivative of the state after the period by the state before.
    """
    multipliers = np.linalg.eigvals(monodromy).astype(np.complex128)
    multipliers = multipliers[np.argsort(-np.abs(multipliers), kind="stable")]
    if not autonomous or len(multipliers) == 0:
        return multipliers, None
    k = int(np.abs(multipliers - 1.0).argmin())
    return np.delete(multipliers, k), complex(multipliers[k])


def is_real(multipliers: np.ndarray) -> np.ndarray:
    """Whether each of the `multipliers` (d,) is real."""
    return np.asarray(np.abs(multipliers.imag) <= REAL * np.maximum(np.abs(multipliers), 1.0))


def nearest_loss(multipliers: np.ndarray, graze: float | None) -> StabilityLoss:
    """Loss of stability by the multiplier (of d) nearest to the unit circle, or by grazing if that is nearer.

    `graze` is the least gap over its travel; None: no gap.
    """
    if len(multipliers) == 0:
        return (
            StabilityLoss("none", np.nan, complex(np.nan))
            if graze is None
            else StabilityLoss(GRAZING, graze, complex(np.nan))
        )
    k = int(np.abs(np.log(np.maximum(np.abs(multipliers), 1e-300))).argmin())
    critical = complex(multipliers[k])
    margin = 1.0 - abs(critical)
    if graze is not None and abs(graze) < min(abs(margin), NEAR):
        return StabilityLoss(GRAZING, graze, complex(np.nan))
    if not is_real(multipliers)[k]:
        return StabilityLoss(NEIMARK_SACKER, margin, critical)
    return StabilityLoss(FOLD if critical.real > 0.0 else FLIP, margin, critical)


def flip_test(multipliers: np.ndarray) -> float:
    """Test function of flips: its sign changes where a real multiplier passes -1; near that the distance to -1."""
    if len(multipliers) == 0:
        return 1.0
    below = int(np.sum(is_real(multipliers) & (multipliers.real < -1.0)))
    return float((-1.0) ** below * np.abs(multipliers + 1.0).min())


def torus_test(multipliers: np.ndarray) -> float:
    """Test function of tori: its sign changes where the product of two multipliers passes 1.

    Near a change its size is the distance of the product to 1.  The product passes 1 if a pair crosses the unit circle.
    It also passes 1 at two real multipliers that are each other's inverse, which is no change of stability (Y. A.
    Kuznetsov, Elements of Applied Bifurcation Theory, 1995, section 10.2).
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
    """Whether the product nearest to 1 belongs to a complex pair of the `multipliers` (d,)."""
    turning = multipliers[~is_real(multipliers)]
    i, j = np.triu_indices(len(multipliers), 1)
    least = np.abs(multipliers[i] * multipliers[j] - 1.0).min(initial=np.inf)
    return bool(len(turning) and np.abs(np.abs(turning) ** 2 - 1.0).min() <= 1.01 * least + 1e-12)
