"""How compiled code is made: records that it is handed as one pointer, and functions that are optimised together."""
