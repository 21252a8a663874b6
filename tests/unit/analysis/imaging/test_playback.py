"""Fields of a digitised playback come under the numbers that the simulated grabber kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from analysis.imaging.playback.chain import Clock
from analysis.imaging.playback.recorded import Recorded, recorded_pictures
from analysis.imaging.playback.sampling import Sampling
from simulators.ektapro.grabber import LINES, Wrong
from tests.playbacks import COLUMNS, ROWS, Digitised, digitised, tape

STANDARDS = st.sampled_from(["ntsc", "pal"])
FRAMES = 24


def fields_of(film: Digitised, standard: str) -> list[NDArray[np.uint8]]:
    sampling = Sampling((0, 0, *LINES[standard]), ROWS, COLUMNS, "top-first")
    return [field for frame in film.frames for field in sampling.pictures(frame)]


def field_times_s(film: Digitised) -> NDArray[np.float64]:
    half_s = 0.5 / film.film_per_s
    return np.array([time_s + later for time_s in film.times_s for later in (0.0, half_s)])


def numbered(film: Digitised, standard: str, **stated: int) -> Recorded:
    first = film.truth[0][0]
    clock = replace(Clock(30.0, first), **stated)  # type: ignore[arg-type]
    if clock.fields_lost:
        times_s = np.arange(2 * len(film.frames)) / (2 * film.film_per_s)
    else:
        times_s = field_times_s(film)
    return recorded_pictures(fields_of(film, standard), times_s, clock)


def shown(film: Digitised) -> list[int]:
    return sorted({number for pair in film.truth for number in pair})


def assert_no_number_is_false(found: Recorded, film: Digitised) -> None:
    """Each picture is that of its number on the tape, and no other: its noise is its own."""
    recorded = np.array([picture.astype(float) for picture in tape(2 * FRAMES, 1)])
    for number, pixels in zip(found.numbers, found.pixels, strict=True):
        misfits = np.square(recorded - pixels).mean(axis=(1, 2))
        assert misfits.argmin() == number


WRONGS = st.builds(
    Wrong,
    st.frozensets(st.integers(2, 2 * FRAMES - 1), max_size=3),
    st.frozensets(st.integers(2, FRAMES - 1), max_size=2),
)


@pytest.mark.long
@settings(max_examples=10, deadline=None)
@example("ntsc", 0.25, 30.0, Wrong(frozenset({6, 7}), frozenset({2}))).via(
    "both fields after a lost frame show one of the lost fields"
)
@given(
    standard=STANDARDS,
    phase=st.floats(0.02, 0.98),
    runs_per_s=st.floats(29.95, 30.05),
    wrong=WRONGS,
)
def test_no_field_of_a_grabber_that_repeats_and_skips_comes_under_a_false_number(
    standard: str, phase: float, runs_per_s: float, wrong: Wrong
) -> None:
    film = digitised(standard, phase=phase, runs_per_s=runs_per_s, frames=FRAMES, wrong=wrong)
    found = numbered(film, standard)
    assert_no_number_is_false(found, film)
    named = {run.number for run in found.doubtful} | set(found.numbers.tolist())
    assert set(shown(film)) - named <= {number + by for number in named for by in (-1, 1)}


@pytest.mark.parametrize("standard", ["ntsc", "pal"])
def test_every_picture_that_a_field_shows_is_found_and_every_other_is_lost(standard: str) -> None:
    wrong = Wrong(frozenset({9, 10, 31}), frozenset({8, 17}))
    film = digitised(standard, frames=FRAMES, wrong=wrong)
    found = numbered(film, standard)
    there = shown(film)
    assert found.numbers.tolist() == there
    assert list(found.lost) == sorted(set(range(there[0], there[-1])) - set(there))
    assert not found.doubtful
    assert found.fields.sum() == 2 * len(film.frames)


def test_frames_left_out_of_a_file_without_times_are_told_by_what_moved() -> None:
    wrong = Wrong(skipped=frozenset({8, 17}))
    film = digitised("pal", frames=FRAMES, wrong=wrong)
    found = numbered(film, "pal", fields_lost=2)
    assert found.numbers.tolist() == shown(film)


def test_where_nothing_moves_frames_may_be_missing_and_the_numbers_are_doubtful() -> None:
    film = digitised("ntsc", frames=FRAMES, moving=False)
    found = numbered(film, "ntsc", fields_lost=2)
    assert found.doubtful
    assert found.doubtful[0].certainty < 0.99
    assert len(found.numbers) < len(shown(film))


def test_a_number_that_the_recorder_shows_makes_doubtful_ones_certain() -> None:
    film = digitised("ntsc", frames=FRAMES, moving=False)
    fields, times_s = fields_of(film, "ntsc"), field_times_s(film)
    last = len(fields) - 1
    counted = {0: film.truth[0][0], last: film.truth[-1][1]}
    clock = Clock(30.0, film.truth[0][0], counted, fields_lost=2)
    found = recorded_pictures(fields, times_s, clock)
    assert found.numbers.tolist() == shown(film)


def test_a_tape_that_stood_before_it_ran_has_its_first_picture_once() -> None:
    film = digitised("ntsc", frames=FRAMES)
    fields = fields_of(film, "ntsc")
    still = [fields[0]] * 9
    times_s = np.arange(len(still) + len(fields)) * 0.5 / film.film_per_s
    clock = Clock(30.0, film.truth[0][0], stands=True)
    found = recorded_pictures([*still, *fields], times_s, clock)
    assert found.numbers.tolist() == shown(film)


def test_a_line_of_either_field_lies_where_it_does_in_the_frame() -> None:
    ramp = np.tile(np.arange(0, 240, 2, dtype=np.uint8)[:, None], (1, 16))
    for scan in ("top-first", "bottom-first"):
        sampling = Sampling((0, 0, 120, 16), 24, 16, scan)  # type: ignore[arg-type]
        for field in sampling.pictures(ramp):
            middle = field[2:-2, 0].astype(float)
            assert np.abs(middle - (10 * np.arange(2, 22) + 4)).max() <= 1.0


def test_fields_without_increasing_times_are_refused() -> None:
    fields = [np.zeros((8, 8), np.uint8)] * 2
    with pytest.raises(ValueError, match="increasing"):
        recorded_pictures(fields, np.array([0.0, 0.0]), Clock(30.0))
