"""Joints: ideal ones are constraints, imperfect ones are contacts or forces."""
