"""Dark markers on a sphere."""
