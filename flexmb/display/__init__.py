"""Display of objects: short texts, and HTML tables for notebooks."""
