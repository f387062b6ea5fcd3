"""Couplings of rotations and travels: gears, racks, belts, screws, equal rotation."""
