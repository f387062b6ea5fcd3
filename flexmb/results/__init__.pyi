"""Public names of `flexmb.results`: classes of results."""

from flexmb.results.contact_intervals import Episode as Episode
from flexmb.results.contact_intervals import Episodes as Episodes
from flexmb.results.positions import Momentum as Momentum
from flexmb.results.solution import Solution as Solution
from flexmb.results.stress import Fatigue as Fatigue
from flexmb.results.stress import WoehlerLine as WoehlerLine
