"""Evaluation of a program in compiled code: elements, contacts, constraints, signals; without any physics."""
