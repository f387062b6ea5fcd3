"""Checks for authors of parts: `check_part` compares every kernel of a part with its contract."""

from flexmb.testing.bench import Check as Check
from flexmb.testing.bench import Report as Report
from flexmb.testing.part import check_part as check_part

__all__ = ["Check", "Report", "check_part"]
