"""Public names of `flexmb.sweeps`: sweeps over parameters."""

from flexmb.sweeps.bifurcation_diagram import bifurcation as bifurcation
from flexmb.sweeps.datasets import load_sweep as load_sweep
from flexmb.sweeps.parameter_sweep import sweep as sweep
