"""Balance of energies over a run, and the work of contacts in a step."""
