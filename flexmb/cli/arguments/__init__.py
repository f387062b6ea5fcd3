"""Arguments of the command line: commands and their options, mechanisms, values with units."""
