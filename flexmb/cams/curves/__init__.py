"""Plane curves: geometry of cams, flats, rollers and outlines, packed as the numbers of kernels."""
