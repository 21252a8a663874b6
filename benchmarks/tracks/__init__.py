"""Whole flights of both spheres beside their truth, and whether stated errors are true."""
