"""Public names of `flexmb.cams`: curves of bodies, lift laws, pairs that touch along curves."""

from flexmb.cams.curve_on_curve import CurveOnCurve as CurveOnCurve
from flexmb.cams.point_on_curve import PointOnCurve as PointOnCurve
from flexmb.cams.curves.closed_curve import ClosedCurve as ClosedCurve
from flexmb.cams.curves.line import Circle as Circle
from flexmb.cams.curves.line import Line as Line
