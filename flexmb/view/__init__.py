"""Pictures of runs, diagrams, orbits and spectra."""
