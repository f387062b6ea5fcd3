"""Loads and springs."""
