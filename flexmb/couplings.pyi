"""Public names of `flexmb.couplings`: couplings of rotations and travels."""

from flexmb.parts.couplings.belt import Belt as Belt
from flexmb.parts.couplings.coupling import Cable as Cable
from flexmb.parts.couplings.coupling import Coupling as Coupling
from flexmb.parts.couplings.coupling import Distance as Distance
from flexmb.parts.couplings.coupling import OneWayClutch as OneWayClutch
from flexmb.parts.couplings.coupling import SameRotation as SameRotation
from flexmb.parts.couplings.wheels import Gear as Gear
from flexmb.parts.couplings.wheels import Rack as Rack
