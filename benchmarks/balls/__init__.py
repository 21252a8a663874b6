"""Films of dropped balls, drawn by ray tracing, and how well they are measured."""

import os

# As `rigctl` does: threads of the algebra library spin, thirty times the work of a fit.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
