"""A pair is learned from a shot only where both spheres are seen to turn."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from analysis.errors import ShotRefusedError
from analysis.photometric.follow.start import first_film
from analysis.setup import Setup
from analysis.tracking import Tracking

DARK = np.full((12, 192, 240), 20, dtype=np.uint8)
TIMES_S = np.arange(12) / 1000.0


@pytest.mark.parametrize("seen", [0, 1])
def test_a_sphere_that_is_seen_in_too_few_orientations_is_refused_by_name(seen: int) -> None:
    often, rarely = SimpleNamespace(frames=np.arange(8)), SimpleNamespace(frames=np.arange(seen))
    tracking = cast("Tracking", SimpleNamespace(orientations=(often, rarely)))
    with pytest.raises(ShotRefusedError, match=f"sphere b has an orientation in {seen} frames"):
        first_film(DARK, TIMES_S, tracking, cast("Setup", None))
