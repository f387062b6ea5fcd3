"""Checks for authors of parts: `check_part` compares every kernel of a part with its contract."""

from flexmb.testing.bench import Check, Report
from flexmb.testing.part import check_part

__all__ = ["Check", "Report", "check_part"]
