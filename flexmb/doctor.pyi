"""Public names of `flexmb.doctor`: what `check` returns."""

from flexmb.findings.finding import CODES as CODES
from flexmb.findings.finding import Finding as Finding
from flexmb.findings.report import Report as Report
