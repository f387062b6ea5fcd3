"""Error of a peak force over rtol: `python tests/speed/peak_errors.py`.

The slider-crank with 0.5 mm of play and friction, two turns.  The peak is the largest force of all steps; a parabola
through the three steps at the crest tells what of its error is the place of the steps.  The reference is
`minimal.worn_reference` with rtol 1e-12, as in `rows.py`.
"""

import models
import numpy as np

import flexmb as fm

PEAK = 45825.04  # N
RTOL = (4e-4, 2e-4, 1e-4, 7e-5, 5e-5, 3e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6)


def crest(t: np.ndarray, force: np.ndarray) -> tuple[float, float]:
    """Top of the parabola through the largest force and its neighbours; distance of the step from it over the step."""
    k = int(force.argmax())
    near = t[k - 1 : k + 2] - t[k]
    curvature, slope, top = np.polyfit(near, force[k - 1 : k + 2], 2)
    away = -slope / (2.0 * curvature)
    return float(top + 0.5 * slope * away), float(-2.0 * away / (near[2] - near[0]))


def errors(rtol: float) -> tuple[int, float, float, float]:
    """Steps; relative errors of the largest force of the steps and of the parabola; distance of the step."""
    sol = fm.simulate(models.worn(), t_end=2.0 * models.TURN, step=fm.Adaptive(rtol=rtol), save="steps")
    force = sol.array("C.normal_force")
    top, away = crest(sol.time, force)
    return sol.stats.steps, float(force.max()) / PEAK - 1.0, top / PEAK - 1.0, away


if __name__ == "__main__":
    print("| rtol | steps | error of the largest step | error of the parabola | distance of the step |")
    print("|---:|---:|---:|---:|---:|")
    for rtol in RTOL:
        steps, of_steps, of_crest, away = errors(rtol)
        print(f"| {rtol:g} | {steps} | {of_steps:.2e} | {of_crest:.2e} | {away:.2f} |")
