"""Normal laws: one file a family of published laws, one for its base."""
