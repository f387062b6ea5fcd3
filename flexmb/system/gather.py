"""Values of a list of coordinates, gathered for one element, signal or control."""

from flexmb.kernels import compiled


@compiled
def gather(values, dofs, begin, n, target):
    """target[:n] = values at the dofs begin .. begin + n."""
    for i in range(n):
        target[i] = values[dofs[begin + i]]
