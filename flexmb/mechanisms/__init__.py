"""Ready mechanisms: functions that return a `Mechanism`, and records of their data."""

from flexmb.mechanisms.andrews import andrews, andrews_angles
from flexmb.mechanisms.four_bar import FourBarData, four_bar
from flexmb.mechanisms.free_rod import FreeRodData, free_rod
from flexmb.mechanisms.n_four_bar import n_four_bar
from flexmb.mechanisms.nine_bar import nine_bar
from flexmb.mechanisms.nine_bar_data import NineBarData
from flexmb.mechanisms.nine_bar_plates import nine_bar_plates
from flexmb.mechanisms.simeon import SimeonData, simeon
from flexmb.mechanisms.slider_crank import SliderCrankData, slider_crank
from flexmb.mechanisms.spinning_beam import SpinningBeamData, spinning_beam

__all__ = [
    "FourBarData",
    "FreeRodData",
    "NineBarData",
    "SimeonData",
    "SliderCrankData",
    "SpinningBeamData",
    "andrews",
    "andrews_angles",
    "four_bar",
    "free_rod",
    "n_four_bar",
    "nine_bar",
    "nine_bar_plates",
    "simeon",
    "slider_crank",
    "spinning_beam",
]
