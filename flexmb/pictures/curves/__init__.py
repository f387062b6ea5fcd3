"""Curves of signals: time histories, portraits, orbits, spectra, diagrams."""
