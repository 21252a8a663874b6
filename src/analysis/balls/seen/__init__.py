"""A ball in a film: what changes, where it is in each frame, and how well that is known."""
