"""Edges of a frame to a fraction of a pixel."""
