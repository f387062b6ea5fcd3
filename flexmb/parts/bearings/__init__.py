"""Bearings: joints with an oil film beside dry contact.

In: films by viscosity and width, measures of a joint with clearance. Out: elements, contacts, signals, coefficients.
"""
