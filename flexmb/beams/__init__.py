"""Beams: sections, materials, element matrices from weak forms, line meshes, the corotational element."""
