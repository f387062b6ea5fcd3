"""Method `Staggered` of the paper: alternating steps of the rigid counterpart and of a linear elastic model."""
