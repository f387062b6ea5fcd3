"""Joints: ideal ones are constraints, imperfect ones are contacts or forces.

In: bodies, points, laws. Out: constraints, gap kernels, friction of joints.
"""
