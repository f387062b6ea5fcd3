"""Poses of a mechanism: its shapes, names and forces as artists of a figure."""
