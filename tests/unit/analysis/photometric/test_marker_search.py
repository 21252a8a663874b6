"""Missed markers stand out from what surrounds them; shadows do not."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.photometric.learn.marker_search import body_directions, local_darkness

ALPHA = 0.16
BODY = body_directions()
SEEN = np.ones(len(BODY), dtype=np.bool_)
MARKER = np.array([0.36, -0.48, 0.80])
NEAR = BODY @ MARKER
"""Cosine of the angle from the marker."""


def test_a_marker_is_as_dark_as_it_is_against_a_light_ring() -> None:
    darkness = np.where(np.cos(ALPHA) < NEAR, 0.7, 0.0)
    local = local_darkness(BODY, darkness, SEEN, ALPHA, 0.0)
    assert NEAR[int(local.argmax())] > np.cos(0.06)
    assert local.max() == pytest.approx(0.7, abs=0.08)


@pytest.mark.parametrize("reach", [0.4, 0.8, 1.5])
def test_a_wide_shadow_is_not_half_as_dark_as_a_marker(reach: float) -> None:
    darkness = np.where(np.cos(reach) < NEAR, 0.7, 0.0)
    assert local_darkness(BODY, darkness, SEEN, ALPHA, 0.0).max() < 0.45 * 0.7 + 0.12


def test_what_is_never_seen_has_no_darkness() -> None:
    darkness = np.where(np.cos(ALPHA) < NEAR, 0.7, 0.0)
    unseen = NEAR < 0.5
    assert not local_darkness(BODY, darkness, unseen, ALPHA, 0.0)[~unseen].any()


def test_caps_that_are_too_light_to_count_need_no_ring() -> None:
    darkness = np.where(np.cos(ALPHA) < NEAR, 0.7, 0.3)
    every = local_darkness(BODY, darkness, SEEN, ALPHA, 0.0)
    few = local_darkness(BODY, darkness, SEEN, ALPHA, 0.5)
    dark = np.array([darkness[own @ BODY.T > np.cos(ALPHA)].mean() for own in BODY]) >= 0.5
    np.testing.assert_array_equal(few[dark], every[dark])
    assert few[~dark].max() < 0.5
