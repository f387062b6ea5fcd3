"""Exact derivatives of laws that are written as a force alone."""
