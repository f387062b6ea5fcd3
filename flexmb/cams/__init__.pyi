"""Public names of `flexmb.cams`: curves of bodies, lift laws, pairs that touch along curves."""

from flexmb.cams.curve_on_curve import CurveOnCurve as CurveOnCurve
from flexmb.cams.curves.closed_curve import ClosedCurve as ClosedCurve
from flexmb.cams.curves.lift import Lift as Lift
from flexmb.cams.curves.line import CircularCurve as CircularCurve
from flexmb.cams.curves.line import Line as Line
from flexmb.cams.curves.outline import Outline as Outline
from flexmb.cams.curves.profiles import flat_profile as flat_profile
from flexmb.cams.curves.profiles import oscillating_flat_profile as oscillating_flat_profile
from flexmb.cams.curves.profiles import oscillating_roller_profile as oscillating_roller_profile
from flexmb.cams.curves.profiles import roller_profile as roller_profile
from flexmb.cams.outline_contact import OutlineContact as OutlineContact
from flexmb.cams.outline_on_outline import OutlineOnOutline as OutlineOnOutline
from flexmb.cams.point_on_curve import PointOnCurve as PointOnCurve
