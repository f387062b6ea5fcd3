"""Restitution of a free impact with the force F(depth) (1 + chi depth_rate/approach), by bisection."""

import math


def delivered(chi: float) -> float:
    """e with chi (1 + e) = ln[(1 + chi)/(1 - chi e)], from m v dv/(1 + chi v/approach) = -F d(depth)."""
    if chi == 0.0:
        return 1.0
    low, high = 1e-9, min(1.0, 1.0 / chi) * (1.0 - 1e-15)
    for _ in range(200):
        e = 0.5 * (low + high)
        # left less right side: positive below the root that is not e = -1
        if chi * (1.0 + e) - math.log((1.0 + chi) / (1.0 - chi * e)) > 0.0:
            low = e
        else:
            high = e
    return 0.5 * (low + high)
