"""State of a run in compiled code: accepted state, trial state, record of a run, options of the method.

In: sizes of a program. Out: records of arrays; a restart is the accepted state, its signals and what the method keeps.
"""
