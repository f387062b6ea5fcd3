"""Public names of `flexmb.plots`: pictures and films of runs, diagrams, orbits and spectra."""

from flexmb.view.bifurcation import plot_bifurcation as plot_bifurcation
from flexmb.view.campbell import plot_campbell as plot_campbell
from flexmb.view.film import animate as animate
from flexmb.view.gltf import export_gltf as export_gltf
from flexmb.view.journal import plot_contact_force as plot_contact_force
from flexmb.view.journal import plot_journal as plot_journal
from flexmb.view.orbits import plot_basin as plot_basin
from flexmb.view.orbits import plot_branch as plot_branch
from flexmb.view.plot import plot as plot
from flexmb.view.portrait import plot_exponents as plot_exponents
from flexmb.view.portrait import plot_phase as plot_phase
from flexmb.view.portrait import plot_section as plot_section
from flexmb.view.render import render as render
from flexmb.view.runs import plot_energies as plot_energies
from flexmb.view.runs import plot_runs as plot_runs
from flexmb.view.screenshot import screenshot_vtk as screenshot_vtk
from flexmb.view.window import view as view
