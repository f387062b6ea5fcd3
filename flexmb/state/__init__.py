"""The state of a run: what was accepted, what a step tries, what is written down, and the numbers of the method."""
