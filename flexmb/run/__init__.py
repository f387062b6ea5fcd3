"""Runs: simulation of a mechanism, at once or step by step."""
