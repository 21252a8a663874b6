"""Frames in, physics out: from images of two spheres to the coefficients of their collision.

Knows no hardware, no server and no database; usable alone in a notebook.
"""
