"""What is told about a mechanism and its runs: errors, warnings, notes, each with a code, a name and a remedy.

In: a mechanism before it moves; poses, peaks and status of a run. Out: findings and remarks. `check` and `report` are public.
"""
