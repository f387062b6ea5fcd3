"""Flexible bodies of any planar shape, by finite elements of plane stress or plane strain."""
