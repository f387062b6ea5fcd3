"""Contact laws: normal forces, friction, onset, coefficient of restitution, validity.

In: stiffness, damping, restitution. Out: kernels N(gap, rate), T(slip, N) with their parameters. Laws know no geometry.
"""
