"""Public names of `flexmb.couplings`: couplings of rotations and travels."""

from flexmb.couplings.belt import Belt as Belt
from flexmb.couplings.cable import Cable as Cable
from flexmb.couplings.coupling import Coupling as Coupling
from flexmb.couplings.distance import Distance as Distance
from flexmb.couplings.gear import Gear as Gear
from flexmb.couplings.one_way_clutch import OneWayClutch as OneWayClutch
from flexmb.couplings.rack import Rack as Rack
from flexmb.couplings.same_rotation import SameRotation as SameRotation
