import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from turning import body_markers, oriented, sight, sighted

from analysis.errors import ShotRefusedError
from analysis.imaging.marker.markers import Markers, film_markers
from analysis.motion.pattern import Orientations, sightings
from analysis.motion.pattern_steps import average_pattern

DEGREES_A_FRAME = 7.0
AXIS = np.array([0.5, 0.7, -0.51])
STEP = math.radians(DEGREES_A_FRAME) * AXIS / np.linalg.norm(AXIS)
START = Rotation.from_rotvec([0.3, -1.0, 0.4])
NOTHING = sighted(np.zeros((0, 3)), np.zeros(0))


@dataclass(frozen=True)
class Turning:
    """A sphere that turns by 7 degrees a frame, and which marker each sighting is."""

    sightings: dict[int, Markers]
    names: dict[int, np.ndarray]
    turns: list[Rotation]
    times_s: np.ndarray


def turning(frames: int = 24, noise: float = 0.0, seed: int = 0) -> Turning:
    rng, body = np.random.default_rng(seed), body_markers()
    turns = [Rotation.from_rotvec(k * STEP) * START for k in range(frames)]
    seen = {k: sight(body, turn, rng, noise) for k, turn in enumerate(turns)}
    return Turning(
        {k: s for k, (s, _) in seen.items()},
        {k: n for k, (_, n) in seen.items()},
        turns,
        np.arange(frames) * 1e-3,
    )


def names_given(truth: Turning, found: Orientations) -> dict[int, set[int]]:
    """Return for each marker of the sphere all names that it was given."""
    given: dict[int, set[int]] = {}
    for k, match in zip(found.frames, found.matches, strict=True):
        for marker, name in zip(truth.names[int(k)], match, strict=True):
            if name >= 0:
                given.setdefault(int(marker), set()).add(int(name))
    return given


def errors(truth: Turning, found: Orientations) -> np.ndarray:
    """Return the angle of each orientation off the truth, the body frames aligned, rad."""
    true = Rotation.concatenate([truth.turns[int(k)] for k in found.frames])
    between = true.inv() * Rotation.from_matrix(found.rotation)
    return (true * between.mean() * Rotation.from_matrix(found.rotation).inv()).magnitude()


def test_no_marker_is_renamed_while_they_come_and_go_round_the_limb() -> None:
    truth = turning()
    found = oriented(truth.sightings, truth.times_s, "a")
    given = names_given(truth, found)
    # 161 degrees of turning bring most of the markers into a view, few stay in it throughout.
    always = set.intersection(*(set(n.tolist()) for n in truth.names.values()))
    assert len(given) >= 12
    assert len(always) <= 4
    assert all(len(names) == 1 for names in given.values())
    assert len({next(iter(names)) for names in given.values()}) == len(given)


def test_exact_markers_give_the_exact_orientation_in_every_frame() -> None:
    truth = turning()
    found = oriented(truth.sightings, truth.times_s, "a")
    assert found.frames.tolist() == list(range(24))
    assert found.left_out == {}
    assert errors(truth, found).max() < 1e-6
    np.testing.assert_allclose(np.linalg.norm(found.pattern, axis=1), 1.0)


def test_the_covariance_says_how_far_noisy_orientations_lie_from_the_truth() -> None:
    squares = []
    for seed in range(12):
        truth = turning(noise=0.02, seed=seed)
        found = oriented(truth.sightings, truth.times_s, "a")
        assert all(len(names) == 1 for names in names_given(truth, found).values())
        stated = np.trace(found.covariance, axis1=1, axis2=2)
        squares.append(np.mean(errors(truth, found) ** 2 / stated))
    assert np.mean(squares) == pytest.approx(1.0, abs=0.35)


def test_a_frame_with_two_markers_is_left_out_and_said_so() -> None:
    truth = turning()
    whole = truth.sightings[9]
    pair = [0, int(np.argmin(np.abs(whole.directions @ whole.directions[0])))]
    truth.sightings[9] = sighted(whole.directions[pair], whole.facing[pair])
    truth.names[9] = truth.names[9][pair]
    found = oriented(truth.sightings, truth.times_s, "a")
    assert 9 not in found.frames
    assert list(found.left_out) == [9]
    assert "only 2 markers" in found.left_out[9]
    assert "3 are needed" in found.left_out[9]
    assert errors(truth, found).max() < 1e-6
    assert all(len(names) == 1 for names in names_given(truth, found).values())


def test_false_markers_get_no_name() -> None:
    truth = turning()
    stray = np.array([[0.36, 0.48, 0.8]])
    k = 12
    seen = truth.sightings[k]
    if np.arccos((seen.directions @ stray.T).max()) < 0.25:
        stray = np.array([[0.0, 0.0, 1.0]])
    truth.sightings[k] = sighted(
        np.concatenate([seen.directions, stray]), np.append(seen.facing, 0.8)
    )
    found = oriented(truth.sightings, truth.times_s, "a")
    assert found.matches[k][-1] == -1
    assert errors(truth, found).max() < 1e-6


def test_a_change_of_spin_at_the_contact_is_followed() -> None:
    rng, body = np.random.default_rng(3), body_markers()
    rates = [STEP] * 12 + [np.array([-0.05, 0.08, 0.06])] * 12
    turns, seen, names = [START], {}, {}
    for rate in rates[1:]:
        turns.append(Rotation.from_rotvec(rate) * turns[-1])
    for k, turn in enumerate(turns):
        seen[k], names[k] = sight(body, turn, rng)
    truth = Turning(seen, names, turns, np.arange(24) * 1e-3)
    found = oriented(seen, truth.times_s, "b")
    assert len(found.frames) == 24
    assert errors(truth, found).max() < 1e-6


def test_a_sphere_without_markers_is_refused_by_name() -> None:
    with pytest.raises(ShotRefusedError) as refusal:
        oriented(dict.fromkeys(range(8), NOTHING), np.arange(8) * 1e-3, "b")
    assert (refusal.value.step, refusal.value.frame) == ("markers", 0)
    assert "sphere b: only 0 markers" in refusal.value.reason


def test_a_sphere_that_is_never_seen_is_refused() -> None:
    with pytest.raises(ShotRefusedError, match="no markers in any frame"):
        oriented({}, np.arange(8) * 1e-3, "b")


def without(truth: Turning, k: int, marker: int) -> Markers:
    kept = truth.names[k] != marker
    seen = truth.sightings[k]
    truth.names[k] = truth.names[k][kept]
    return sighted(seen.directions[kept], seen.facing[kept])


def test_a_marker_that_both_views_show_for_the_first_time_at_once_is_one() -> None:
    truth = turning(noise=0.01)
    names, counts = np.unique(truth.names[10], return_counts=True)
    late = int(names[counts == 2][0])
    for k in range(10):
        truth.sightings[k] = without(truth, k, late)
    found = oriented(truth.sightings, truth.times_s, "a")
    given = names_given(truth, found)
    assert len(given[late]) == 1
    others = [name for marker, called in given.items() if marker != late for name in called]
    assert next(iter(given[late])) not in others
    assert len(found.pattern) == len(given)


def test_the_spin_bridges_frames_that_are_lost() -> None:
    truth = turning()
    # Three steps of 7 degrees are further than a marker is looked for around its last place.
    for k in (7, 8, 15, 16):
        del truth.sightings[k]
    found = oriented(truth.sightings, truth.times_s, "a")
    assert len(found.frames) == 20
    assert errors(truth, found).max() < 1e-6
    assert all(len(names) == 1 for names in names_given(truth, found).values())


@pytest.mark.parametrize("seed", range(4))
def test_a_marker_that_both_views_show_stands_in_the_pattern_once(seed: int) -> None:
    truth = turning(noise=0.015, seed=seed)
    seen_twice = [k for k, names in truth.names.items() if len(set(names.tolist())) < len(names)]
    assert len(seen_twice) > 5
    found = oriented(truth.sightings, truth.times_s, "a")
    between = np.arccos(np.clip(found.pattern @ found.pattern.T, -1, 1)) + 4 * np.eye(
        len(found.pattern)
    )
    assert between.min() > 0.5


def test_two_markers_that_both_views_show_are_not_four() -> None:
    rng = np.random.default_rng(1)
    pair = np.array([[-0.7, 0.1, 0.7], [-0.6, 0.6, 0.5]])
    seen = {}
    for k in range(8):
        shown = np.concatenate([pair, pair]) + 0.01 * rng.standard_normal((4, 3))
        shown /= np.linalg.norm(shown, axis=1, keepdims=True)
        seen[k] = sighted(shown, np.full(4, 0.7))
    with pytest.raises(ShotRefusedError, match="only 2 markers"):
        oriented(seen, np.arange(8) * 1e-3, "a")


def test_a_marker_that_was_seen_on_the_limb_alone_has_no_place_in_the_pattern() -> None:
    own = sighted(np.eye(3), np.array([0.9, 0.0, 0.7]))
    match, turns = np.tile(np.arange(3), 4), np.tile(np.eye(3), (4, 1, 1))
    pattern = average_pattern(
        sightings(film_markers(dict.fromkeys(range(4), own))), turns, np.ones(4, np.bool_), match, 3
    )
    assert match.tolist() == [0, -1, 1] * 4
    assert pattern == pytest.approx(np.eye(3)[[0, 2]])


@pytest.mark.parametrize("strange", [1, 2])
def test_first_frames_that_no_other_follows_are_left_out(strange: int) -> None:
    truth, other = turning(), turning(seed=1)
    for k in range(strange):
        # As if another sphere stood there, turned by half a turn.
        truth.sightings[k] = other.sightings[12 + 11 * k]
    found = oriented(truth.sightings, truth.times_s, "a")
    assert found.frames.tolist()[-10:] == list(range(14, 24))
    assert set(range(strange)) & set(found.frames.tolist()) == set()
    assert len(found.frames) >= 24 - strange - 2


def test_a_beginning_that_leads_astray_does_not_end_the_track() -> None:
    truth = turning(48)
    # Its first frames are strange, and follow each other as if they were a sphere turning faster.
    fast = [Rotation.from_rotvec(9.0 * k * STEP) * START for k in range(4)]
    rng = np.random.default_rng(3)
    truth.sightings.update({k: sight(body_markers(), turn, rng)[0] for k, turn in enumerate(fast)})
    found = oriented(truth.sightings, truth.times_s, "a")
    assert set(range(4, 48)) <= set(found.frames.tolist())
    kept = [int(k) for k in found.frames if k >= 4]
    later = np.isin(found.frames, kept)
    true = Rotation.concatenate([truth.turns[k] for k in kept])
    turns = Rotation.from_matrix(found.rotation[later])
    assert np.ptp((true.inv() * turns).as_quat(canonical=True), axis=0).max() < 0.003
