"""Findings on mechanisms and on runs: errors, warnings, notes, each with a name and a remedy.

In: a mechanism before it moves; poses, peaks and status of a run. Out: findings and remarks. What is particular to a
part or law is asked of it.
"""
