"""Systems: flows and maps, of mechanisms and of equations."""
