"""Planar flexible multibody dynamics with imperfect joints.

Declare a `Mechanism` of parts, `simulate` it, ask questions of the motion.

The names that most scripts need are here. The others lie in namespaces: `contact` (normal laws), `friction`,
`couplings` (gears, belts, racks, rods), `drives`, `chaos` (exponents, sections, orbits, basins, verdicts, signals),
`sweeps`, `mechanisms` (ready ones), `plots`, `results` and `equilibrium` (classes of results), `errors`, `kernels`
(compiled functions of one's own parts) and `testing` (checks of one's own parts).
"""

from flexmb.namespace import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__, __file__)
