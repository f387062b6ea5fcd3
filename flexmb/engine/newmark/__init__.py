"""The Newmark family: implicit methods of second order, with the Newton iteration of their steps.

In: an accepted state, a step. Out: a trial state with its error estimate; `engine/step` has the map of a step.
"""
