"""Controllers and motors: laws of one's own, PID, direct-current motor.

In: signals, gains. Out: control kernels with states, and the loads that they scale.
"""
