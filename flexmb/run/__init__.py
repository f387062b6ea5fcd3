"""Runs: a mechanism simulated, at once or step by step."""
