"""Pictures and films of runs, diagrams, orbits and spectra."""
