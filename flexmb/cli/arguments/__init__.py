"""Arguments of the command line: commands and their options, mechanisms, values with units.

In: words typed in a shell. Out: a command with its options, a mechanism, numbers in SI units. Nothing is run here.
"""
