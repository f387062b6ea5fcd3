"""Public names of `flexmb.plots`: pictures and films of runs, diagrams, orbits and spectra."""

from flexmb.pictures.curves.bifurcation import plot_bifurcation as plot_bifurcation
from flexmb.pictures.curves.campbell import plot_campbell as plot_campbell
from flexmb.pictures.curves.journal import plot_contact_force as plot_contact_force
from flexmb.pictures.curves.journal import plot_journal as plot_journal
from flexmb.pictures.curves.orbits import plot_basin as plot_basin
from flexmb.pictures.curves.orbits import plot_branch as plot_branch
from flexmb.pictures.curves.plot import plot as plot
from flexmb.pictures.curves.portrait import plot_exponents as plot_exponents
from flexmb.pictures.curves.portrait import plot_phase as plot_phase
from flexmb.pictures.curves.portrait import plot_section as plot_section
from flexmb.pictures.curves.runs import plot_energies as plot_energies
from flexmb.pictures.curves.runs import plot_runs as plot_runs
from flexmb.pictures.curves.spectrum import plot_spectrum as plot_spectrum
from flexmb.pictures.films.film import animate as animate
from flexmb.pictures.films.gltf import export_gltf as export_gltf
from flexmb.pictures.films.window import view as view
from flexmb.pictures.poses.render import render as render
from flexmb.pictures.poses.screenshot import screenshot_vtk as screenshot_vtk
