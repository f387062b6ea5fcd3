"""Pages of the nine-bar study beside the claims."""
