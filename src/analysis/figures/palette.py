"""Colours for colour-blind readers too (M. Okabe and K. Ito, Color Universal Design, 2008)."""

SPHERE_A = "#56B4E9"
SPHERE_B = "#E69F00"
MEASURED = "#0072B2"
FAILS = "#D55E00"
FLOOR = "#009E73"
GREY = "#6B6B6B"
SPHERES = (SPHERE_A, SPHERE_B)
