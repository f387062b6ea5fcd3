"""Couplings of rotations and travels: gears, racks, belts, any linear relation, rods, cables.

In: joints, ratios, radii. Out: constraints; contacts where there is backlash or slack.
"""
