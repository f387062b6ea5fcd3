"""Public names of `flexmb.equilibrium`: classes of equilibria and linear analyses."""

from flexmb.equilibrium.buckling import Buckling as Buckling
from flexmb.equilibrium.found import Equilibrium as Equilibrium
from flexmb.equilibrium.modes import Modes as Modes
