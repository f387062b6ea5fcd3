"""Kinds of figures: each makes a figure of a study from a row of its table."""
