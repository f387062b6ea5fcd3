"""The Newmark family: implicit methods of second order, with the Newton iteration of their steps."""
