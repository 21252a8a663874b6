"""What the thesis prints of its accuracy runs, to set beside ours."""

from __future__ import annotations

import numpy as np

INCH_M = 0.0254

DROPS_IN_PER_S2 = (384.8, 383.9, 384.6, 384.5, 382.9, 385.4, 383.8, 383.7, 385.7, 385.4)
"""Table 6.1."""
LOCAL_GRAVITY_IN_PER_S2 = 385.92
"""Normal gravity at 40.74 degrees north; the thesis divides by 386.4."""

ANGLES_DEG = (5.982, 11.964, 17.946, 23.928, 29.910, 35.892, 41.874)
COMPUTED_DEG = (5.993, 11.974, 17.973, 23.961, 29.965, 35.938, 41.866)
DEVIATIONS_DEG = (0.221, 0.262, 0.272, 0.202, 0.232, 0.245, 0.247)
"""Table 6.2; the last computed angle is from its relative error."""

MEASURED_Z_IN_PER_S = {"v_n": -68.330, "v_n_after": 48.052, "v_s": 170.586, "v_s_after": 149.526}
CONSTANT_Z_IN_PER_S = {"v_n": -68.588, "v_n_after": 47.824, "v_s": 170.679, "v_s_after": 149.608}
"""Table 3.3; the signs of its printed errors are mixed."""

STAGE_PX = 0.25
"""Accuracy that section 4.2 states for Canny's edges with shell clustering."""


def drop_mean_and_deviation() -> tuple[float, float]:
    """Return mean and standard deviation of table 6.1, m/s^2."""
    values = INCH_M * np.array(DROPS_IN_PER_S2)
    return float(values.mean()), float(values.std(ddof=1))


def z_errors() -> dict[str, float]:
    """Return (constant - measured) / measured of table 3.3, and of the e it implies.

    That of v_s_after over v_s, as ours.
    """
    with_z, without = MEASURED_Z_IN_PER_S, CONSTANT_Z_IN_PER_S
    errors = {name: without[name] / with_z[name] - 1.0 for name in ("v_n", "v_n_after", "v_s")}
    errors["v_s_after"] = (without["v_s_after"] - with_z["v_s_after"]) / with_z["v_s"]
    errors["e"] = (1.0 + errors["v_n_after"]) / (1.0 + errors["v_n"]) - 1.0
    return errors
