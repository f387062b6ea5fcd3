"""Ready mechanisms: functions that return a `Mechanism`, and records of their data."""

from typing import Any

from flexmb import checks
from flexmb.mechanisms.four_bar import FourBarData, four_bar
from flexmb.mechanisms.nine_bar import NineBarData, nine_bar
from flexmb.mechanisms.slider_crank import SliderCrankData, slider_crank

__all__ = ["FourBarData", "NineBarData", "SliderCrankData", "four_bar", "nine_bar", "slider_crank"]


def __getattr__(name: str) -> Any:
    names = checks.did_you_mean(name, __all__, what="Names")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}. {names}")
