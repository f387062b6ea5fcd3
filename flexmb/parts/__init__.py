"""Parts of mechanisms: bodies, joints, contact laws, loads, drives, couplings, cams, controllers, sensors.

In: numbers and names that a user gives. Out: contributions to a program (`model.contributions`), shapes for pictures,
remarks on a run. A part knows `model` and the contracts of kernels.
"""
