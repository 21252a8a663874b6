"""A true pose shows its markers as dark as they are expected, however small they are drawn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.photometric.follow.confirmation import LEAST_SHARE, shown_share
from analysis.photometric.render.sight import Sight, Stance
from tests.unit.analysis.photometric.drawn import (
    sight_of,
    sphere_image,
    spread_markers,
    stance_at,
    with_noise,
)

MARKERS = spread_markers(18, seed=4)
NOISE, MIDDLE = 1.0, 31.3


def seen(radius: float, *, motion_px: float = 0.0) -> tuple[Sight, Stance]:
    """Draw a sphere, smeared along the columns by the mean of its places, and its true pose."""
    steps = np.linspace(-0.5, 0.5, 15) * motion_px
    places = [(MIDDLE, MIDDLE + step) for step in steps]
    image = np.mean([sphere_image(place=p, radius=radius, markers=MARKERS) for p in places], axis=0)
    sight = sight_of(with_noise(image, NOISE, seed=1), MARKERS, radius=radius, noise=NOISE)
    motion = np.array([0.0, motion_px / radius, 0.0, 0.0, 0.0, 0.0])
    return sight._replace(motion=motion), stance_at(MIDDLE, MIDDLE, radius)


@pytest.mark.parametrize("radius", [8.0, 10.0, 20.0])
def test_markers_of_a_true_pose_are_as_dark_as_expected(radius: float) -> None:
    # With a radius of 8 pixels the blur leaves two thirds of the darkness of a marker's middle.
    share, count = shown_share(*seen(radius))
    assert count >= 4
    assert share == pytest.approx(1.0, abs=0.08)


def test_markers_smeared_by_their_own_width_are_as_dark_as_expected() -> None:
    share, _ = shown_share(*seen(10.0, motion_px=3.0))
    assert share == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("radius", [10.0, 20.0])
def test_a_wrong_turn_does_not_show_its_markers(radius: float) -> None:
    sight, stance = seen(radius)
    wrong = Rotation.from_rotvec([0.15, -0.4, 0.26]).as_matrix()
    share, _ = shown_share(sight, stance._replace(rotation=wrong))
    assert share < LEAST_SHARE
