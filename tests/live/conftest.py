"""Live pages for several files."""

import pytest

import flexmb as fm
from flexmb.mechanisms import slider_crank

VARY = {"speed": (50.0, 500.0), "clearance": (1e-5, 5e-4)}


@pytest.fixture(scope="module")
def crank_page():
    """A live page of a slider-crank with clearance."""
    with fm.explore(slider_crank, vary=VARY, periods=1, open=False, block=False) as page:
        yield page
