"""Public names of `flexmb.equilibrium`: classes of equilibria and linear analyses."""

from flexmb.statics.buckling import Buckling as Buckling
from flexmb.statics.equilibrium import Equilibrium as Equilibrium
from flexmb.statics.modes import Modes as Modes
