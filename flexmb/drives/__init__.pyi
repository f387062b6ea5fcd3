"""Public names of `flexmb.drives`: drives, and the motions that they prescribe."""

from flexmb.drives.constant_speed import ConstantSpeed as ConstantSpeed
from flexmb.drives.drive import Drive as Drive
from flexmb.drives.harmonic import Harmonic as Harmonic
from flexmb.drives.piecewise_linear import PiecewiseLinear as PiecewiseLinear
from flexmb.drives.polynomial import Polynomial as Polynomial
from flexmb.drives.pulse import Pulse as Pulse
from flexmb.drives.ramp import CycloidalRamp as CycloidalRamp
from flexmb.drives.ramp import Ramp as Ramp
from flexmb.drives.table import Table as Table
