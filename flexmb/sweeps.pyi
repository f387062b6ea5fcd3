"""Public names of `flexmb.sweeps`: sweeps over parameters."""

from flexmb.dynamics.sweeps.bifurcation import bifurcation as bifurcation
from flexmb.dynamics.sweeps.parameter_sweep import load_sweep as load_sweep
from flexmb.dynamics.sweeps.parameter_sweep import sweep as sweep
from flexmb.dynamics.sweeps.wear import wear_out as wear_out
