"""Verdicts on motions: periodic, quasi-periodic, chaotic, transient or inconclusive, with a reason."""
