"""Sweeps over parameters on any executor, with persistent stores: bifurcation diagrams, grids and designs."""
