"""An own contact law: one kernel and one frozen class in the user's own file; nothing else has to be told about it.

The law is a linear spring with a viscous damper, N = k depth + d depth_rate, cut at zero.  A block dropped onto such a
floor makes a damped half oscillation: with the damping ratio D = d / (2 sqrt(k m)) the coefficient of restitution is

    e = exp(-D w (t_end)) ...  until N vanishes:   e = exp(-(D / sqrt(1 - D^2)) (pi - atan2(2 D sqrt(1 - D^2), 2 D^2 - 1) ...
"""
