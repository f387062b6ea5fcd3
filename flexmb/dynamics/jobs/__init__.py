"""Calls on any executor: outcomes, chains of jobs, worker processes of this machine, files that are whole.

In: calls. Out: results or errors in the order of the calls. It knows nothing of mechanics.
"""
