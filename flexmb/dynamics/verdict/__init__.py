"""The verdict on a motion: periodic, quasi-periodic, chaotic, transient or inconclusive."""
