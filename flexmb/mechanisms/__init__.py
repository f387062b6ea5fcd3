"""Ready mechanisms: functions that return a `Mechanism`, and the records of their numbers."""

from flexmb.mechanisms.andrews import andrews, andrews_angles
from flexmb.mechanisms.four_bar import FourBarData, four_bar
from flexmb.mechanisms.n_four_bar import n_four_bar
from flexmb.mechanisms.nine_bar import nine_bar
from flexmb.mechanisms.nine_bar_data import NineBarData
from flexmb.mechanisms.slider_crank import SliderCrankData, slider_crank

__all__ = [
    "FourBarData",
    "NineBarData",
    "SliderCrankData",
    "andrews",
    "andrews_angles",
    "four_bar",
    "n_four_bar",
    "nine_bar",
    "slider_crank",
]
