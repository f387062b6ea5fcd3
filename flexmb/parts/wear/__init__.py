"""Wear: joints whose surfaces lose material where they slide under pressure.

In: coefficients of wear, profiles of surfaces, a joint with clearance. Out: contacts of worn surfaces, signals, depths.
"""
