from __future__ import annotations

import pytest

from simulators.ektapro.tape import RecordingFormat, Tape

WHOLE_TAPE = [(1000, 30.0, 30_000), (30, 960.0, 28_800)]


@pytest.mark.parametrize(("rate", "seconds", "pictures"), WHOLE_TAPE)
def test_the_tape_holds_what_the_thesis_says(rate: int, seconds: float, pictures: int) -> None:
    recording_format = RecordingFormat(rate)
    assert recording_format.tape_duration_s == pytest.approx(seconds)
    assert Tape().room(recording_format, 0.0) == pictures


@pytest.mark.parametrize("rate", [60, 125, 250, 500])
def test_other_rates_lie_between_the_two_that_are_given(rate: int) -> None:
    assert 28_800 < Tape().room(RecordingFormat(rate), 0.0) < 30_000


@pytest.mark.parametrize(
    ("split", "per_s", "rows"),
    [(1, 1000, 192), (2, 2000, 96), (3, 3000, 64), (4, 4000, 48), (6, 6000, 32)],
)
def test_split_pictures_share_the_rows_and_multiply_the_rate(
    split: int, per_s: int, rows: int
) -> None:
    recording_format = RecordingFormat(1000, split)
    assert (recording_format.pictures_per_s, recording_format.rows) == (per_s, rows)
    assert Tape().room(recording_format, 0.0) == 30_000 * split


@pytest.mark.parametrize(("rate", "split"), [(999, 1), (0, 1), (1000, 5), (1000, 0), (2000, 1)])
def test_a_format_the_recorder_lacks_is_refused(rate: int, split: int) -> None:
    with pytest.raises(ValueError, match="one of"):
        RecordingFormat(rate, split)


def test_a_picture_is_taken_at_each_instant_from_the_first() -> None:
    session = Tape().begin(RecordingFormat(1000), first_s=50.0)
    counts = [session.count(time) for time in (49.9999, 50.0, 50.0009, 50.001, 50.1)]
    assert counts == [0, 1, 1, 2, 101]


def test_sessions_lie_one_behind_the_other_and_use_the_tape_up() -> None:
    tape = Tape()
    full, slow = RecordingFormat(1000), RecordingFormat(30)
    first = tape.begin(full, 0.0)
    first.pictures = 15_000
    assert tape.room(full, 100.0) == 15_000
    assert tape.room(slow, 100.0) == 14_400
    second = tape.begin(slow, 100.0)
    assert (second.number, second.room) == (2, 14_400)
    assert second.count(1e6) == 14_400
    assert tape.room(full, 1e6) == 0


def test_erasing_loses_every_session_and_gives_all_the_tape_back() -> None:
    tape = Tape()
    tape.begin(RecordingFormat(1000), 0.0).pictures = 1000
    tape.erase()
    assert (list(tape.sessions), tape.room(RecordingFormat(1000), 0.0)) == ([], 30_000)
