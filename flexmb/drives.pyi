"""Public names of `flexmb.drives`: drives, and the motions that they prescribe."""

from flexmb.parts.drives.motions import ConstantSpeed as ConstantSpeed
from flexmb.parts.drives.motions import CycloidalRamp as CycloidalRamp
from flexmb.parts.drives.motions import Drive as Drive
from flexmb.parts.drives.motions import Harmonic as Harmonic
from flexmb.parts.drives.motions import PiecewiseLinear as PiecewiseLinear
from flexmb.parts.drives.motions import Polynomial as Polynomial
from flexmb.parts.drives.motions import Pulse as Pulse
from flexmb.parts.drives.motions import Ramp as Ramp
from flexmb.parts.drives.motions import Table as Table
