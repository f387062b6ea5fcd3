"""Public names of `flexmb.wear`: joints that wear, their laws, and the wear of a run."""

from flexmb.parts.wear.worn_bearing import WornBearing as WornBearing
from flexmb.parts.wear.worn_clearance import WornClearance as WornClearance
from flexmb.parts.wear.worn_guide import WornGuide as WornGuide
from flexmb.parts.wear.worn_guide import WornSlot as WornSlot
from flexmb.parts.wear.worn_joint import Archard as Archard
from flexmb.parts.wear.worn_joint import EnergyWear as EnergyWear
from flexmb.parts.wear.worn_joint import Worn as Worn
