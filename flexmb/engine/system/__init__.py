"""Evaluation of a program in compiled code: elements, contacts, constraints, signals; without any physics.

In: tables of a program, a state. Out: residuals, matrices, signals, or the kernel that fails. Physics is in kernels.
"""
