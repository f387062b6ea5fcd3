"""From declarations to flat arrays: numbering, packing, smoke calls, names."""
