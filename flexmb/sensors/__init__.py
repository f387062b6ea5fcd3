"""Sensors: parts that measure and exert no force."""
