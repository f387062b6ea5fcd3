"""Parameters varied on any executor, in stores that survive: bifurcation diagrams, grids and designs."""
