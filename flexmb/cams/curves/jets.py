"""Truncated Taylor series in one variable: functions with their derivatives, multiplied and composed.

A jet is an array (orders, n) of derivatives 0, 1, 2, ... at n places, each divided by the factorial of its order.
"""

from __future__ import annotations

import math

import numpy as np

Jet = np.ndarray


def from_derivatives(derivatives: np.ndarray) -> Jet:
    """Jet of a function with these derivatives (orders, n)."""
    return np.array([row / math.factorial(k) for k, row in enumerate(derivatives)])


def derivatives_of(jet: Jet) -> np.ndarray:
    """Derivatives (orders, n) of a jet."""
    return np.array([row * math.factorial(k) for k, row in enumerate(jet)])


def constant(value: float, like: Jet) -> Jet:
    """Jet of a constant, of the shape of another jet."""
    jet = np.zeros_like(like)
    jet[0] = value
    return jet


def slope(jet: Jet) -> Jet:
    """Jet of the derivative, one order shorter."""
    return np.array([(k + 1) * jet[k + 1] for k in range(len(jet) - 1)])


def times(a: Jet, b: Jet) -> Jet:
    """Product, of the shorter order."""
    orders = min(len(a), len(b))
    return np.array([sum(a[i] * b[k - i] for i in range(k + 1)) for k in range(orders)])


def cos_sin(jet: Jet) -> tuple[Jet, Jet]:
    """Cosine and sine of a jet, by their differential equations."""
    c, s = np.zeros_like(jet), np.zeros_like(jet)
    c[0], s[0] = np.cos(jet[0]), np.sin(jet[0])
    for k in range(1, len(jet)):
        c[k] = -sum(i * jet[i] * s[k - i] for i in range(1, k + 1)) / k
        s[k] = sum(i * jet[i] * c[k - i] for i in range(1, k + 1)) / k
    return c, s


def over(a: Jet, b: Jet) -> Jet:
    """Quotient, of the shorter order."""
    orders = min(len(a), len(b))
    found = np.zeros((orders, *np.shape(a)[1:]))
    for k in range(orders):
        found[k] = (a[k] - sum(found[i] * b[k - i] for i in range(k))) / b[0]
    return found


def root(jet: Jet) -> Jet:
    """Square root of a jet > 0."""
    found = np.zeros_like(jet)
    found[0] = np.sqrt(jet[0])
    for k in range(1, len(jet)):
        found[k] = (jet[k] - sum(found[i] * found[k - i] for i in range(1, k))) / (2.0 * found[0])
    return found
