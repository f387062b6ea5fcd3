"""Basins of attraction of flows and maps, over a grid of start values."""
