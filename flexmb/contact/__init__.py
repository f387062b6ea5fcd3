"""Contact laws: normal forces and friction, and what they share."""
