"""Public names of `flexmb.equilibrium`: classes of equilibria and linear analyses."""

from flexmb.equilibrium.buckling import Buckling as Buckling
from flexmb.equilibrium.modes import Modes as Modes
from flexmb.equilibrium.statics import Equilibrium as Equilibrium
