"""How much of a direct image is seen as what it is: areas of discs, by elementary geometry."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.photometric.follow.visibility import own_shares

SHAPE = (192, 240)
FAR = [-1e6, -1e6, 0.0]


def discs(front, above):
    return np.array([[*front, 20.0], [*above, 20.0], FAR, FAR])


def test_a_disc_in_the_frame_and_clear_of_the_mirror_is_seen_whole():
    assert own_shares(discs((140, 120), (46, 120)), 0, SHAPE) == (1.0, 1.0)


@pytest.mark.parametrize(("row", "column"), [(191.5, 120.0), (140.0, -0.5), (140.0, 239.5)])
def test_half_of_a_disc_on_the_edge_of_the_frame_is_seen(row, column):
    inside, free = own_shares(discs((row, column), (46, 120)), 0, SHAPE)
    assert inside == pytest.approx(0.5, abs=0.02)
    assert free == inside


def test_a_direct_image_before_its_own_mirror_image_is_not_seen_as_such():
    inside, free = own_shares(discs((46, 120), (46, 120)), 0, SHAPE)
    assert (inside, free) == (1.0, 0.0)


def test_what_two_discs_share_is_the_lens_between_them():
    apart, radius, reach = 25.0, 20.0, 22.6
    to_chord = (apart**2 + radius**2 - reach**2) / (2 * apart)
    own = radius**2 * np.arccos(to_chord / radius) - to_chord * np.sqrt(radius**2 - to_chord**2)
    beyond = apart - to_chord
    other = reach**2 * np.arccos(beyond / reach) - beyond * np.sqrt(reach**2 - beyond**2)
    _, free = own_shares(discs((46 + apart, 120), (46, 120)), 0, SHAPE)
    assert free == pytest.approx(1 - (own + other) / (np.pi * radius**2), abs=0.03)


def test_the_mirror_image_of_the_other_sphere_counts_too():
    seen = np.array([[140.0, 100.0, 20.0], [46.0, 100.0, 20.0], [46.0, 140.0, 20.0], FAR])
    seen[3] = [46.0, 140.0, 20.0]
    assert own_shares(seen, 1, SHAPE) == (1.0, 0.0)
