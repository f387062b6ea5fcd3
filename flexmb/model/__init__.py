"""Declarations: small frozen dataclasses of names and numbers, no arrays, no solving."""
