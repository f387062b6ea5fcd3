"""Moving pictures: films, the window, and glTF files."""
