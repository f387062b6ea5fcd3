"""Basins of attraction: where motions from a grid of states end."""
