"""Checks for those who write parts: `check_part` holds every kernel of a part against its contract."""

from flexmb.testing.part import check_part as check_part
from flexmb.testing.report import Check as Check
from flexmb.testing.report import Report as Report
