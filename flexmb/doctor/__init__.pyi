"""Public names of `flexmb.doctor`: what `check` returns."""

from flexmb.doctor.finding import CODES as CODES
from flexmb.doctor.finding import Finding as Finding
from flexmb.doctor.report import Report as Report
