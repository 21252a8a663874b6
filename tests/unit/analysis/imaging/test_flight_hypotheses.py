"""Flights of discs that move by several of their radii, found by motion and not by nearness."""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats
from analysis.imaging.flight_hypotheses import (
    Falling,
    Four,
    free_flights,
    guide,
    meeting,
    mirrored,
)

RADIUS, FRAMES, CONTACT = 10.0, 20, 9.4
FALLING = Falling(np.arange(FRAMES) / 250.0, 1.2e5)
"""Discs fall by 1.9 pixels more in every frame than in the one before."""
VIEW = (-np.inf, np.inf)
TOUCH = np.array([[300.0, 390.0], [300.0, 410.0]])
BEFORE = np.array([[0.0, 45.0], [0.0, -38.0]])
"""Pixels a frame, of a and b: more than four radii."""


def collision(after: Floats, touch: Floats = TOUCH) -> Floats:
    """Return the places of a and b, pixels, shape (2, frames, 2)."""
    since = np.arange(FRAMES)[:, None] - CONTACT
    gained = FALLING.gravity_px / 250.0**2
    fallen = np.concatenate([0.5 * gained * since**2 + 4.0 * since, 0.0 * since], axis=1)
    return np.stack(
        [touch[i] + fallen + since * np.where(since < 0, BEFORE[i], after[i]) for i in (0, 1)]
    )


def shown(paths: Floats, rng: np.random.Generator) -> list[Floats]:
    """Return the discs of each frame, in any order and off by half a pixel, one beside them."""
    still = np.array([[40.0, 700.0]])
    frames = [np.concatenate([paths[:, k], still]) for k in range(FRAMES)]
    return [rng.permutation(each) + 0.3 * rng.standard_normal(each.shape) for each in frames]


def found(after: Floats, seed: int = 0, lost: tuple[int, ...] = ()) -> tuple[Floats, Floats]:
    """Return true places and those that are found, shape (2, frames, 2)."""
    paths = collision(after)
    places = shown(paths, np.random.default_rng(seed))
    for k in lost:
        places[k] = places[k][:0]
    four = meeting((places, places), VIEW, (RADIUS, RADIUS), FALLING)
    assert four is not None
    return paths, guide(four, FALLING)


def test_spheres_that_come_back_keep_their_names() -> None:
    for seed in range(5):
        paths, places = found(np.array([[0.0, -30.0], [0.0, 31.0]]), seed)
        np.testing.assert_allclose(places, paths, atol=2.0)


def test_spheres_that_exchange_their_velocities_keep_their_names() -> None:
    # Each leaves as the other one came, a diameter beside its path.
    paths, places = found(BEFORE[::-1].copy())
    np.testing.assert_allclose(places, paths, atol=2.0)


def test_a_sphere_that_is_struck_sideways_is_found_again() -> None:
    paths, places = found(np.array([[-35.0, 5.0], [36.0, 4.0]]))
    np.testing.assert_allclose(places, paths, atol=2.0)


def test_frames_without_discs_are_bridged() -> None:
    paths, places = found(np.array([[0.0, -30.0], [0.0, 31.0]]), lost=(4, 14))
    np.testing.assert_allclose(places, paths, atol=2.0)


def test_a_sphere_that_leaves_into_the_rows_of_the_mirror_is_found_again() -> None:
    # Struck upward it shows in two frames below row 250, and the mirror shows both above it.
    paths = collision(np.array([[-35.0, 5.0], [36.0, 4.0]]))
    mirror = np.stack([np.array([[20.0, p[1]], [60.0, q[1]]]) for p, q in zip(*paths, strict=True)])
    places = [
        np.concatenate([own, shown_there])
        for own, shown_there in zip(shown(paths, np.random.default_rng(0)), mirror, strict=True)
    ]
    four = meeting((places, places), (250.0, np.inf), (RADIUS, RADIUS), FALLING)
    assert four is not None
    seen = guide(four, FALLING)
    np.testing.assert_allclose(seen[0, :17], paths[0, :17], atol=2.0)
    np.testing.assert_allclose(seen[1], paths[1], atol=2.0)


def test_spheres_that_pass_far_from_each_other_do_not_meet() -> None:
    paths = collision(BEFORE)
    paths[1, :, 0] += 10 * RADIUS
    places = shown(paths, np.random.default_rng(0))
    assert meeting((places, places), VIEW, (RADIUS, RADIUS), FALLING) is None


def test_what_stands_still_is_no_flight() -> None:
    still = [np.array([[100.0, 100.0]])] * FRAMES
    assert not free_flights(still, RADIUS, Falling(FALLING.times_s, 0.0))


def four_and_mirror(rows: Floats) -> tuple[Four, Floats, list[Floats]]:
    """Return flights that meet, true places in the mirror and its discs.

    Parameters
    ----------
    rows
        In the mirror's view, of a and b, shape (2, frames); not a number where it shows no disc.
    """
    paths = collision(np.array([[0.0, -30.0], [0.0, 31.0]]))
    direct = shown(paths, np.random.default_rng(0))
    four = meeting((direct, direct), VIEW, (RADIUS, RADIUS), FALLING)
    assert four is not None
    places = np.stack([rows, paths[..., 1] + 3.0], axis=-1)
    discs = [places[::-1, k][np.isfinite(places[::-1, k, 0])] for k in range(FRAMES)]
    return four, places, discs


def test_flights_have_their_own_discs_in_the_mirror() -> None:
    since = np.arange(FRAMES) - CONTACT
    rows = np.stack([50.0 + np.where(since < 0, 1.0, -6.0) * since, 50.0 + 0.0 * since])
    rows[0, 3] = rows[1, 5] = rows[1, 14:] = np.nan
    four, places, discs = four_and_mirror(rows)
    # Something stands still before the mirror, which a's columns pass in one frame.
    discs[6] = np.concatenate([discs[6], [[80.0, places[0, 6, 1]]]])
    found = mirrored(four, (discs, discs), (RADIUS, RADIUS), 3.0, FALLING)
    for i, flown in enumerate(found):
        frames = np.concatenate([own.frames for own in flown])
        assert frames.tolist() == np.flatnonzero(np.isfinite(rows[i])).tolist()
        for own in flown:
            np.testing.assert_allclose(own.places, places[i, own.frames])


def test_one_disc_in_the_mirror_after_contact_is_taken_where_it_can_be_no_others() -> None:
    rows = np.full((2, FRAMES), 50.0)
    rows[:, 11:] = np.nan
    rows[:, 10] = 30.0, 70.0
    four, places, discs = four_and_mirror(rows)
    a, b = mirrored(four, (discs, discs), (RADIUS, RADIUS), 3.0, FALLING)
    assert [own.frames.tolist() for own in (a[1], b[1])] == [[10], [10]]
    np.testing.assert_allclose([a[1].places[0], b[1].places[0]], places[:, 10])
    # Two discs in one sphere's columns: which is its own nobody knows.
    discs[10] = np.concatenate([discs[10], [[75.0, places[0, 10, 1]]]])
    a, b = mirrored(four, (discs, discs), (RADIUS, RADIUS), 3.0, FALLING)
    assert len(a) == 1
    assert len(b) == 2


def test_spheres_that_leave_side_by_side_have_their_own_discs_in_the_mirror() -> None:
    """They touch one before the other: their columns are alike, and the mirror tells them apart."""
    touch = np.array([[293.0, 398.0], [307.0, 402.0]])
    paths = collision(np.array([[-35.0, 5.0], [36.0, 4.0]]), touch)
    direct = shown(paths, np.random.default_rng(0))
    four = meeting((direct, direct), VIEW, (RADIUS, RADIUS), FALLING)
    assert four is not None
    since = np.arange(FRAMES) - CONTACT
    left = np.where(since > 0, 15.0 * since, 0.0)
    rows = np.stack([56.5 + left, 43.5 - left])
    rows[:, 13:] = np.nan
    places = np.stack([rows, paths[..., 1]], axis=-1)
    for order in (1, -1):
        discs = [places[::order, k][np.isfinite(rows[:, k])] for k in range(FRAMES)]
        found = mirrored(four, (discs, discs), (RADIUS, RADIUS), 0.0, FALLING)
        for i, flown in enumerate(found):
            seen = np.concatenate([own.places for own in flown])
            np.testing.assert_allclose(seen, places[i, :13])
