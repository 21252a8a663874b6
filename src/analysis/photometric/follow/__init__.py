"""A known pair found in a film and followed through it."""
