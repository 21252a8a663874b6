"""Tracks that leave free flight are cut there; others stay whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from analysis.model.data.inside import without_contact_frames, without_torn_tracks
from analysis.model.data.poses import PoseData
from analysis.model.fitting.robust_fit import robust_fit
from tests.unit.analysis.model.hard_spheres import campaign


def running_away(data: PoseData, shot: int, sphere: int, first: int) -> PoseData:
    """Return the data with the depth of a sphere running away from a frame on."""
    position = data.position.copy()
    late = np.arange(position.shape[1]) - first
    position[shot, :, sphere, 2] += np.where(late >= 0, 1e-3 * (late + 1), 0.0)
    return replace(data, position=position)


def test_a_track_that_runs_away_ends_where_it_does() -> None:
    data = without_torn_tracks(running_away(campaign(6, 3), 2, 1, 19))
    seen = np.isfinite(data.position_sigma).all(axis=3)
    assert data.torn == ((3, "b", 19, 23),)
    assert not seen[2, 19:, 1].any()
    assert not np.isfinite(data.rotation_sigma[2, 19:, 1]).any()
    assert seen[2, :19, 1].all()
    assert seen[2, :, 0].all()


def test_tracks_before_contact_are_cut_toward_their_beginning() -> None:
    data = campaign(6, 4)
    position = data.position.copy()
    position[0, :4, 0, 0] += 5e-3
    cut = without_torn_tracks(replace(data, position=position))
    assert np.array_equal(
        np.flatnonzero(~np.isfinite(cut.position_sigma[0, :, 0, 0])), np.arange(4)
    )
    assert cut.torn == ((1, "a", 0, 3),)


def test_spheres_that_touch_again_are_flagged_with_frames_and_reason() -> None:
    """Both are kicked apart once more six frames before the end."""
    data = campaign(30, 7, position_sigma=2e-6, rotation_sigma=2e-4)
    position, later = data.position.copy(), np.maximum(data.times_s[3] - data.times_s[3, 17], 0.0)
    for sphere, side in ((0, -1.0), (1, 1.0)):
        position[3, :, sphere] += side * later[:, None] * np.array([0.0, 0.3, -0.1])
    found = robust_fit(replace(data, position=position))
    assert {track[:2] for track in found.account.torn} == {(4, "a"), (4, "b")}
    assert all(first in (17, 18) and last == 23 for _, _, first, last in found.account.torn)
    assert "a second contact" in found.remarks()[0]
    fitted = found.fit.parameters()["e"]
    assert abs(fitted.value - 0.74) < 4.0 * fitted.sigma


def test_free_flights_stay_whole_and_single_bad_frames_are_left_to_the_law() -> None:
    data = campaign(40, 5)
    assert without_torn_tracks(data) is data
    position = data.position.copy()
    position[1, 20, 0] += 4e-3
    assert without_torn_tracks(replace(data, position=position)).torn == ()


def test_what_is_fitted_has_no_torn_tracks() -> None:
    assert without_contact_frames(running_away(campaign(6, 6), 0, 0, 18)).torn == (
        (1, "a", 18, 23),
    )
