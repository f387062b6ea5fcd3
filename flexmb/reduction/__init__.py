"""Bodies by few coordinates: Craig-Bampton bases, the element that they make, and the kernel of that element."""
