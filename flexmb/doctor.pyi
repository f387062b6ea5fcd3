"""Public names of `flexmb.doctor`: what `check` returns."""

from flexmb.findings.check import Report as Report
from flexmb.findings.finding import CODES as CODES
from flexmb.findings.finding import Finding as Finding
