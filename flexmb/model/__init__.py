"""Declarations: frozen dataclasses of names and numbers, without arrays and solvers."""
