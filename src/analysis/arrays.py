"""Arrays of numbers, as most of the analysis takes and gives them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
