"""Public names of `flexmb.cams`: curves of bodies, lift laws, pairs that touch along curves."""

from flexmb.parts.cams.curve_on_curve import CurveOnCurve as CurveOnCurve
from flexmb.parts.cams.curve_on_curve import PointOnCurve as PointOnCurve
from flexmb.parts.cams.curves import CircularCurve as CircularCurve
from flexmb.parts.cams.curves import ClosedCurve as ClosedCurve
from flexmb.parts.cams.curves import Line as Line
from flexmb.parts.cams.outline import Outline as Outline
from flexmb.parts.cams.outline_contact import OutlineContact as OutlineContact
from flexmb.parts.cams.outline_contact import OutlineOnOutline as OutlineOnOutline
from flexmb.parts.cams.profiles import Lift as Lift
from flexmb.parts.cams.profiles import flat_profile as flat_profile
from flexmb.parts.cams.profiles import oscillating_flat_profile as oscillating_flat_profile
from flexmb.parts.cams.profiles import oscillating_roller_profile as oscillating_roller_profile
from flexmb.parts.cams.profiles import roller_profile as roller_profile
