"""Evaluation of a program in compiled code: elements, contacts, constraints, signals; without any physics.

In: tables of a program, a state. Out: residuals, matrices, signals, or the kernel that fails there. The physics is in
the kernels that it calls.
"""
