"""Figures in files. Colours are Okabe and Ito's: sphere a sky blue, sphere b orange, everywhere."""
