"""Calls on any executor: outcomes, chains of jobs, worker processes of this machine, progress."""
