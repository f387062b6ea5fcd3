"""Public names of `flexmb.plots`: pictures and films of runs, diagrams, orbits and spectra."""

from flexmb.pictures.bifurcation import plot_bifurcation as plot_bifurcation
from flexmb.pictures.campbell import plot_campbell as plot_campbell
from flexmb.pictures.film import animate as animate
from flexmb.pictures.gltf import export_gltf as export_gltf
from flexmb.pictures.journal import plot_contact_force as plot_contact_force
from flexmb.pictures.journal import plot_journal as plot_journal
from flexmb.pictures.orbits import plot_basin as plot_basin
from flexmb.pictures.orbits import plot_branch as plot_branch
from flexmb.pictures.plot import plot as plot
from flexmb.pictures.portrait import plot_exponents as plot_exponents
from flexmb.pictures.portrait import plot_phase as plot_phase
from flexmb.pictures.portrait import plot_section as plot_section
from flexmb.pictures.render import render as render
from flexmb.pictures.runs import plot_energies as plot_energies
from flexmb.pictures.runs import plot_runs as plot_runs
from flexmb.pictures.screenshot import screenshot_vtk as screenshot_vtk
from flexmb.pictures.window import view as view
