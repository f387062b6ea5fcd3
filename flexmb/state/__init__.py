"""State of a run in compiled code: accepted state, trial state, record of a run, options of the method."""
