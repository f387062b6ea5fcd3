"""Public names of `flexmb.plots`: pictures of runs, diagrams, orbits and spectra."""

from flexmb.view.bifurcation import plot_bifurcation as plot_bifurcation
from flexmb.view.orbits import plot_basin as plot_basin
from flexmb.view.orbits import plot_branch as plot_branch
from flexmb.view.plot import plot as plot
from flexmb.view.portrait import plot_exponents as plot_exponents
from flexmb.view.portrait import plot_phase as plot_phase
from flexmb.view.portrait import plot_section as plot_section
from flexmb.view.render import render as render
from flexmb.view.screenshot import screenshot_vtk as screenshot_vtk
from flexmb.view.spectrum import plot_spectrum as plot_spectrum
