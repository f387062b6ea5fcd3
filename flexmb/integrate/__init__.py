"""Motion in time: methods, step control, the compiled loop, and the record of a run."""
