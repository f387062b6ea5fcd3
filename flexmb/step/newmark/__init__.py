"""The Newmark family: implicit steps of second order."""
