"""A cantilever under a transverse load at its tip, bent far beyond the linear range, against the exact elastica.

With the load P always in the direction -Y and alpha = P L^2 / (E I), Bisshopp and Drucker (Quart. Appl. Math. 3 (1945)
272-275) give, for the modulus k with

    K(k) - F(phi1, k) = sqrt(alpha),   sin phi1 = 1 / (k sqrt 2),

the deflection of the tip

    d / L = 1 - 2 (E(k) - E(phi1, k)) / sqrt(alpha).
"""

import math

from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import flexmb as fm

L, alpha = 1.0, 5.0
section = fm.Rectangle(width=0.02, height=0.002)
steel = fm.Material(young=207e9, density=7850.0)
P = alpha * steel.young * 0.02 * 0.002**3 / 12 / L**2


def exact_deflection():
    def angle(m):
        return math.asin(1 / math.sqrt(2 * m))

    m = brentq(lambda m: ellipk(m) - ellipkinc(angle(m), m) - math.sqrt(alpha), 0.5 + 1e-12, 1 - 1e-12)
    return L * (1 - 2 * (ellipe(m) - ellipeinc(angle(m), m)) / math.sqrt(alpha))


exact = exact_deflection()
print(f"load {P:.3f} N, deflection of the tip {exact:.6f} m (exact, for an inextensible bar)")
for elements in (4, 8, 16, 32):
    root, tip = (0.0, 0.0), (L, 0.0)
    beam = fm.FlexibleLink("beam", root, tip, section=section, material=steel, elements=elements)
    clamp = fm.Fixed("clamp", fm.GROUND, beam, at=root)
    mech = fm.Mechanism("cantilever", [beam, clamp, fm.Force("P", beam, at=tip, force=(0.0, -P))], gravity=(0.0, 0.0))
    equilibrium = fm.static_equilibrium(mech)
    d = -equilibrium["beam.end.y"]
    moment = equilibrium.force("clamp")[2]
    print(f"{elements:3d} elements: {d:.6f} m, error {abs(d / exact - 1):.1e}; clamping moment {moment:.4f} N m")
