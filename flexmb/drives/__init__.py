"""Drives: prescribed motion of a joint."""
