"""The published scheme: steps of the rigid counterpart and of linear elasticity about it, in turn."""
