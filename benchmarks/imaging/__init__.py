"""How well and how fast frames are measured: python -m benchmarks.imaging SECTION.

Spheres of 40 pixels are ray-cast by the simulators, blurred, given read noise and rounded. Every
section prints what was measured beside what is asked and writes out/imaging-*.json:

centres  errors beside the Cramer-Rao bound, and beside OpenCV, scikit-image and trackpy
radius   of the disc, which is the scale, under other light and blur
pairs    rotation between two frames, and markers mixed up
speed    frames/s, ms a shot, learning and first use, on one core
"""
