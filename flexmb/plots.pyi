"""Public names of `flexmb.plots`: pictures and films of runs, diagrams, orbits and spectra."""

from flexmb.show.pictures.diagrams import plot_basin as plot_basin
from flexmb.show.pictures.diagrams import plot_bifurcation as plot_bifurcation
from flexmb.show.pictures.diagrams import plot_branch as plot_branch
from flexmb.show.pictures.diagrams import plot_exponents as plot_exponents
from flexmb.show.pictures.diagrams import plot_phase as plot_phase
from flexmb.show.pictures.diagrams import plot_report as plot_report
from flexmb.show.pictures.diagrams import plot_section as plot_section
from flexmb.show.pictures.diagrams import plot_tornado as plot_tornado
from flexmb.show.pictures.diagrams import plot_wear as plot_wear
from flexmb.show.pictures.films import animate as animate
from flexmb.show.pictures.films import export_gltf as export_gltf
from flexmb.show.pictures.scene import render as render
from flexmb.show.pictures.signals import plot as plot
from flexmb.show.pictures.signals import plot_campbell as plot_campbell
from flexmb.show.pictures.signals import plot_contact_force as plot_contact_force
from flexmb.show.pictures.signals import plot_energies as plot_energies
from flexmb.show.pictures.signals import plot_journal as plot_journal
from flexmb.show.pictures.signals import plot_pressure as plot_pressure
from flexmb.show.pictures.signals import plot_residuals as plot_residuals
from flexmb.show.pictures.signals import plot_runs as plot_runs
from flexmb.show.pictures.signals import plot_spectrum as plot_spectrum
from flexmb.show.pictures.window import screenshot_vtk as screenshot_vtk
from flexmb.show.pictures.window import view as view
