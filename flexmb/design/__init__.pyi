"""Public names of `flexmb.design`: derivatives by parameters, and measures of signals."""

from flexmb.design.derivatives import Normal as Normal
from flexmb.design.derivatives import Sensitivity as Sensitivity
from flexmb.design.derivatives import Spread as Spread
from flexmb.design.derivatives import Uniform as Uniform
from flexmb.design.derivatives import sensitivity as sensitivity
from flexmb.design.derivatives import spread as spread
from flexmb.design.fitting import Fit as Fit
from flexmb.design.fitting import fit as fit
from flexmb.design.measures import Measure as Measure
from flexmb.design.measures import at_end as at_end
from flexmb.design.measures import largest as largest
from flexmb.design.measures import mean as mean
from flexmb.design.measures import peak as peak
from flexmb.design.measures import rms as rms
from flexmb.design.measures import smallest as smallest
from flexmb.design.optimum import Optimum as Optimum
from flexmb.design.optimum import optimise as optimise
from flexmb.design.orbits import OrbitSensitivity as OrbitSensitivity
from flexmb.design.orbits import StaticSensitivity as StaticSensitivity
from flexmb.design.orbits import orbit_sensitivity as orbit_sensitivity
from flexmb.design.orbits import static_sensitivity as static_sensitivity
