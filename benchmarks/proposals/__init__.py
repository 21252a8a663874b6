"""Laws that no catalogue holds: how often one is proposed, how often the right one, how fast."""

import os

# Read when linear algebra loads; matrices are small, and processor time counts every thread.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
