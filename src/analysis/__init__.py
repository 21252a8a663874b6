"""Frames in, physics out: from images of two spheres to the coefficients of their collision.

Independent of hardware, server and database; usable alone in a notebook.
"""
