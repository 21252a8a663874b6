"""A stream hands out, part by part, what a campaign in memory would be after the same changes."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.model.data import parts
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from tests.unit.analysis.model.data.parts import gathered, streamed
from tests.unit.analysis.model.hard_spheres import campaign

SHOTS = 23


@pytest.fixture(autouse=True)
def ten_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "SHOTS_AT_ONCE", 10)


@pytest.fixture(scope="module")
def data() -> PoseData:
    return campaign(SHOTS, 5)


def test_a_stream_has_all_shots_in_their_order(data: PoseData) -> None:
    stream = streamed(data, 7)
    assert [len(part.shots) for part in stream.parts()] == [10, 10, 3]
    assert stream.shots.tolist() == list(range(1, SHOTS + 1))
    np.testing.assert_array_equal(gathered(stream, "position"), data.position)


def test_shots_that_are_taken_out_stay_out_whatever_is_taken_next(data: PoseData) -> None:
    odd = streamed(data, 5).of_shots(data.shots % 2 == 1)
    late = odd.of_shots(odd.shots > 9)
    assert late.shots.tolist() == list(range(11, SHOTS + 1, 2))
    assert np.concatenate([part.shots for part in late.parts()]).tolist() == late.shots.tolist()
    assert [part.count for part in late.parts()] == [7]


def test_sigmas_are_divided_shot_by_shot_and_multiplied_kind_by_kind(data: PoseData) -> None:
    weight = np.linspace(0.2, 1.0, SHOTS)
    stream = streamed(data, 6, 3).held_down(weight).with_noise(2.0, 3.0)
    wanted = data.held_down(weight)
    np.testing.assert_allclose(
        gathered(stream, "position_sigma"), 2.0 * wanted.position_sigma, rtol=1e-14
    )
    np.testing.assert_allclose(
        gathered(stream, "rotation_sigma"), 3.0 * wanted.rotation_sigma, rtol=1e-14
    )


def test_weights_belong_to_the_shots_that_were_left_when_they_were_given(data: PoseData) -> None:
    left = data.shots > 10
    weight = np.linspace(0.5, 1.0, int(left.sum()))
    stream = streamed(data, 6).of_shots(left).held_down(weight)
    wanted = data.of_shots(left).held_down(weight)
    np.testing.assert_allclose(
        gathered(stream, "position_sigma"), wanted.position_sigma, rtol=1e-14
    )


def test_frames_go_by_the_number_of_their_shot(data: PoseData) -> None:
    stream = streamed(data, 6).without_frames([(8, 3)]).without_frames([(21, 0), (99, 1)])
    gone = ~gathered(stream, "measured").any(axis=(2, 3))
    assert np.argwhere(gone).tolist() == [[7, 3], [20, 0]]


def test_a_change_of_all_parts_is_made_once_and_kept(data: PoseData) -> None:
    calls = []

    def change(part: PoseData) -> PoseData:
        calls.append(len(part.shots))
        return without_contact_frames(part)

    stream = streamed(data, 7).changed(change)
    for _ in range(2):
        found = gathered(stream, "measured")
    np.testing.assert_array_equal(found, without_contact_frames(data).measured)
    assert calls == [10, 10, 3]


def test_a_stream_of_nothing_has_no_shots() -> None:
    assert streamed(campaign(4, 1), 4).of_shots(np.zeros(4, dtype=bool)).shots.size == 0
