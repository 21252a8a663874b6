"""`rigctl analyse` of films as people take them: each oddity is said, what holds is given."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.balls import measuring
from analysis.balls.flight.lost import Found
from analysis.balls.gaps import Gap
from tests.unit.cli import odd_films
from tests.unit.cli.falling_ball import (
    DIAMETER_MM,
    RADIUS,
    RATE,
    SIZE,
    Capsys,
    analysed,
    answer,
    bouncing,
    picture,
    said,
    save,
)


def is_true(impact: Any, e: float) -> bool:
    found = impact["e"]
    return bool(abs(found["value"] - e) < 4 * found["sigma"] and found["sigma"] < 0.01)


@pytest.mark.parametrize("odd_first", [False, True])
def test_fields_of_an_interlaced_film_are_measured_each_at_its_own_time(
    odd_first: bool, tmp_path: Path, capsys: Capsys
) -> None:
    shot = analysed(odd_films.interlaced(odd_first=odd_first), tmp_path, capsys, 100)
    note = said(shot, "interlaced")
    assert "50 pictures are 100 fields" in note
    assert ("odd rows first" in note) is odd_first
    assert is_true(shot["impacts"][0], 0.8)
    # Frames count fields, 200 a second.
    assert shot["impacts"][0]["frame"] == pytest.approx(67.6, abs=0.2)


def test_a_hand_that_holds_the_ball_and_lets_it_go_is_left_out(
    tmp_path: Path, capsys: Capsys
) -> None:
    pictures, release = odd_films.released()
    shot = analysed(pictures, tmp_path, capsys)
    assert is_true(shot["impacts"][0], 0.8)
    assert min(shot["impacts"][0]["frames_before"]) >= release
    assert "in frames 0 to" in said(shot, "held or rests")
    assert "(40, 60)" in said(shot, "held or rests")


def test_a_ball_that_a_codec_skips_while_it_rests_is_in_no_flight_and_no_picture_shown_twice(
    tmp_path: Path, capsys: Capsys
) -> None:
    pictures, released = odd_films.skipped_by_a_codec()
    shot = analysed(pictures, tmp_path, capsys, 50)
    assert not any("once more" in note for note in shot["notes"])
    assert "in frames 0 to" in said(shot, "held or rests")
    assert min(shot["impacts"][0]["frames_before"]) >= released - 3
    assert all(abs(i["e"]["value"] - 0.8) < 4 * i["e"]["sigma"] < 0.08 for i in shot["impacts"])
    assert len(shot["impacts"]) == 2


def test_a_hand_that_moves_beside_the_ball_is_no_ball(tmp_path: Path, capsys: Capsys) -> None:
    shot = analysed(odd_films.hand_beside(), tmp_path, capsys)
    assert is_true(shot["impacts"][0], 0.8)
    assert not any("another ball" in note for note in shot["notes"])


def test_a_ball_that_leaves_on_a_side_has_its_flight_and_place_until_there(
    tmp_path: Path, capsys: Capsys
) -> None:
    pictures, gone = odd_films.leaves_on_a_side()
    shot = analysed(pictures, tmp_path, capsys)
    note = said(shot, "leaves the picture at frame")
    frame = int(note.split("frame ")[1].split()[0])
    assert gone - 20 < frame < gone
    assert shot["impacts"] == []
    assert len(shot["positions"]["frame"]) > 40


def test_places_of_a_ball_lit_from_one_side_have_its_radius_s_error_without_a_bounce_too(
    tmp_path: Path, capsys: Capsys
) -> None:
    rows = bouncing()[:60]
    shot = analysed(odd_films.lit_from_above(rows), tmp_path, capsys)
    assert shot["impacts"] == []
    placed = shot["positions"]
    off = np.array(placed["row_px"]) - np.array(rows)[placed["frame"]]
    stated = np.array(placed["sigma_row_px"])
    assert np.sqrt(np.mean((off / stated) ** 2)) < 2.0
    assert np.median(stated) < 0.5
    # Beside one another they are as good as those of any ball.
    assert np.median(placed["scatter_row_px"]) < 0.05
    diameter = shot["ball"]["diameter_px"]
    assert abs(diameter["value"] - 2 * RADIUS) < 3 * diameter["sigma"]


def test_places_of_a_ball_that_fades_into_the_ground_are_where_its_rims_are(
    tmp_path: Path, capsys: Capsys
) -> None:
    """A smooth shading alone has them nearer to the light."""
    rows = bouncing()
    shot = analysed(odd_films.lit_from_above(rows), tmp_path, capsys)
    placed = shot["positions"]
    off = np.array(placed["row_px"]) - np.array(rows)[placed["frame"]]
    assert abs(np.median(off)) < 0.12
    assert is_true(shot["impacts"][0], 0.8)


def test_a_ball_that_comes_back_from_above_the_picture_is_in_one_flight(
    tmp_path: Path, capsys: Capsys
) -> None:
    shot = analysed(odd_films.leaves_and_comes_back(), tmp_path, capsys)
    assert len(shot["impacts"]) == 2
    assert all(is_true(impact, 0.9) for impact in shot["impacts"])
    assert "out of the picture" in said(shot, "not seen between frames")


@pytest.mark.parametrize(("light", "frames"), [(0.38, 8), (0.5, 30)])
def test_what_is_no_ball_is_not_said_to_be_it_before_the_ball_enters(
    light: float, frames: int, tmp_path: Path, capsys: Capsys
) -> None:
    shot = analysed(odd_films.wall_before_the_ball(light, frames), tmp_path, capsys)
    assert is_true(shot["impacts"][0], 0.9)
    assert not any("or what looks like it" in note for note in shot["notes"])


@pytest.mark.parametrize("after", [4, 6])
def test_a_last_flight_that_the_film_s_end_cuts_counts_from_four_frames_on(
    after: int, tmp_path: Path, capsys: Capsys
) -> None:
    """The first frame after the bounce, 67.6, is next to it."""
    shot = analysed([picture(row) for row in bouncing(69 + after)], tmp_path, capsys)
    assert is_true(shot["impacts"][0], 0.8)


def test_a_film_that_ends_two_frames_after_a_bounce_says_so(tmp_path: Path, capsys: Capsys) -> None:
    shot = analysed([picture(row) for row in bouncing(71)], tmp_path, capsys)
    assert "the film ends 2 frames later, at frame 70" in said(shot, "no bounce")


def test_a_ball_that_rolls_away_after_its_bounce_is_said_with_frames_and_places(
    tmp_path: Path, capsys: Capsys
) -> None:
    pictures, first = odd_films.rolls_away()
    shot = analysed(pictures, tmp_path, capsys)
    assert is_true(shot["impacts"][0], 0.6)
    assert f"in frames {first} to 169" in said(shot, "rolls along the plate")


def test_pictures_that_a_film_shows_twice_are_said_and_do_not_count(
    tmp_path: Path, capsys: Capsys
) -> None:
    pictures, twice = odd_films.frames_twice()
    shot = analysed(pictures, tmp_path, capsys)
    assert ", ".join(map(str, twice[:-1])) in said(shot, "once more")
    assert not set(twice) & set(shot["impacts"][0]["frames_before"])
    assert is_true(shot["impacts"][0], 0.8)


def test_a_picture_that_a_codec_has_coded_anew_is_the_one_before_it_all_the_same(
    tmp_path: Path, capsys: Capsys
) -> None:
    """Where the ball moves by enough: at the top of a flight it hardly moves in any frame."""
    pictures, twice = odd_films.frames_twice(off_px=0.15)
    shot = analysed(pictures, tmp_path, capsys)
    named = {int(n) for n in re.findall(r"\d+", said(shot, "once more").split("(")[1])}
    assert len(named & set(twice)) >= 7
    assert not named - set(twice)
    assert is_true(shot["impacts"][0], 0.8)


@pytest.mark.parametrize(("pictures", "frames", "off_px"), [(4, 5, 0.15), (1, 2, 0.0)])
def test_a_film_that_was_brought_to_another_rate_is_measured_at_its_camera_s(
    pictures: int, frames: int, off_px: float, tmp_path: Path, capsys: Capsys
) -> None:
    """As from 24 to 30 frames/s, and from 30 to 60."""
    drawn = odd_films.brought_to_rate(pictures, frames, off_px=off_px)
    shot = analysed(drawn, tmp_path, capsys, rate=round(RATE * frames / pictures))
    note = said(shot, f"each {frames} frames show {pictures} picture")
    assert f"its 100 pictures are measured as {RATE:.0f} a second" in note
    assert not any("once more (" in each for each in shot["notes"])
    assert is_true(shot["impacts"][0], 0.8)
    assert len(shot["positions"]["frame"]) > 90


@pytest.mark.parametrize(
    ("first", "count"),
    [
        (50, 4),
        (66, 1),
        *(
            pytest.param(first, count, marks=pytest.mark.long)
            for first, count in [(40, 1), (48, 2), (64, 2), (69, 1), (83, 3)]
        ),
    ],
)
def test_frames_that_a_film_lacks_are_said_and_its_times_mended(
    first: int, count: int, tmp_path: Path, capsys: Capsys
) -> None:
    """In flight, and beside the first bounce, which is between frames 67 and 68."""
    shot = analysed(odd_films.frames_missing(first, count), tmp_path, capsys)
    words = f"{count} frames seem" if count > 1 else "1 frame seems"
    named = re.search(r"before frame (\d+)", said(shot, words))
    assert named is not None
    assert abs(int(named[1]) - first) <= 3
    assert all(is_true(impact, 0.8) for impact in shot["impacts"])


def test_one_bounce_alone_says_that_it_does_not_show_frames_missing_at_it(
    tmp_path: Path, capsys: Capsys
) -> None:
    """The flights before and after it meet all the same, on a plate that lies higher."""
    shot = analysed(odd_films.frames_missing(67, 3), tmp_path, capsys)
    (impact,) = shot["impacts"]
    e = impact["e"]
    assert abs(e["value"] - 0.8) > 3 * e["sigma"]
    note = said(shot, "does not show whether the film has all frames")
    each = float(note.split("e is ")[1].split()[0])
    assert e["value"] + 3 * each == pytest.approx(0.8, abs=2 * e["sigma"])


def test_a_film_with_more_gaps_than_are_mended_is_said(
    tmp_path: Path, capsys: Capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measuring, "MOST_GAPS", 0)
    monkeypatch.setattr(measuring, "find_gap", lambda *_: Found(Gap(90, 1), np.zeros(1)))
    shot = analysed(odd_films.frames_missing(50, 0), tmp_path, capsys)
    assert "not to be believed" in said(shot, "missing at more places")


def test_of_two_balls_the_one_that_falls_as_its_stated_size_says_is_measured(
    tmp_path: Path, capsys: Capsys
) -> None:
    shot = analysed(odd_films.two_that_fall_otherwise(), tmp_path, capsys)
    assert is_true(shot["impacts"][0], 0.8)
    assert shot["scale_px_per_m"]["agree"]
    assert max(shot["positions"]["column_px"]) < 120.0
    assert "180) px" in said(shot, "another ball flies")


def test_a_film_that_stands_upside_down_is_told_though_something_falls_upright_in_it(
    tmp_path: Path, capsys: Capsys
) -> None:
    shot = analysed(odd_films.upside_down_after_a_fall(), tmp_path, capsys)
    assert "upside down" in shot["notes"][0]
    assert is_true(shot["impacts"][0], 0.8)


@pytest.mark.long
def test_bounces_are_found_by_a_camera_to_which_they_are_a_bend_of_a_pixel_a_frame(
    tmp_path: Path, capsys: Capsys
) -> None:
    shown = [picture(row) for row in bouncing(800, per_frame=4)]
    shot = analysed(shown, tmp_path, capsys, rate=4 * round(RATE))
    assert [is_true(impact, 0.8) for impact in shot["impacts"]] == [True, True]


@pytest.mark.parametrize(
    ("rate", "diameter", "unit", "right"),
    [
        (RATE / 8, DIAMETER_MM, "frames/s", RATE),
        (RATE, DIAMETER_MM / 10, "mm", DIAMETER_MM),
        (RATE, DIAMETER_MM * 10, "mm", DIAMETER_MM),
    ],
)
def test_a_film_in_slow_motion_and_a_diameter_in_another_unit_are_told_by_the_fall(
    tmp_path: Path, capsys: Capsys, rate: float, diameter: float, unit: str, right: float
) -> None:
    film = save(tmp_path / "film", odd_films.frames_missing(0, 0))
    size = ("--ball-diameter-mm", str(diameter))
    shot = answer(capsys, str(film), *size, "--fps", str(rate))
    assert shot["status"] == "refused"
    proposed = re.search(rf"about ([\d.]+) {unit}", shot["reason"])
    assert proposed is not None, shot["reason"]
    assert float(proposed[1]) == pytest.approx(right, rel=0.03)
    assert "upside down" not in shot["reason"]
    assert len(shot["positions"]["frame"]) > 100


def test_the_rate_that_is_proposed_for_an_interlaced_film_is_that_of_its_frames(
    tmp_path: Path, capsys: Capsys
) -> None:
    film = save(tmp_path / "film", odd_films.interlaced(odd_first=False))
    shot = answer(capsys, str(film), *SIZE, "--fps", str(RATE / 16))
    proposed = re.search(r"about ([\d.]+) frames/s \(--fps\)", shot["reason"])
    assert proposed is not None, shot["reason"]
    assert float(proposed[1]) == pytest.approx(RATE / 2, rel=0.05)


def test_a_fall_of_few_frames_is_too_short_to_tell_and_not_said_to_be_held(
    tmp_path: Path, capsys: Capsys
) -> None:
    film = save(tmp_path / "film", [picture(row) for row in bouncing()[60:68]])
    shot = answer(capsys, str(film), *SIZE, "--fps", str(RATE))
    assert shot["status"] == "refused"
    assert "35 ms, in which a fall bends by 0.43 px" in shot["reason"]
    assert "held" not in shot["reason"]


def test_a_film_of_noise_is_not_taken_for_an_interlaced_one(tmp_path: Path, capsys: Capsys) -> None:
    film = save(tmp_path / "film", odd_films.noise_alone(2.0))
    shot = answer(capsys, str(film), *SIZE, "--fps", "200")
    assert (shot["status"], shot["step"]) == ("refused", "ball")
    assert "of its 24 frames" in shot["reason"]


@pytest.mark.parametrize(
    "changes",
    [
        pytest.param(
            lambda t: t + np.maximum(t - 76 / RATE, 0.0), id="half the rate after a bounce"
        ),
        *(
            pytest.param(change, id=name, marks=pytest.mark.long)
            for name, change in {
                "a slower rate after a bounce": lambda t: t + 0.2 * np.maximum(t - 68 / RATE, 0.0),
                "half the rate before a bounce": lambda t: t + np.maximum(t - 44 / RATE, 0.0),
                "half the rate at a bounce": lambda t: t + np.maximum(t - 84 / RATE, 0.0),
                "twice the rate after a bounce": lambda t: t - 0.5 * np.maximum(t - 108 / RATE, 0),
                "a rate that drifts": lambda t: t + 0.01 * np.sin(6.0 * t),
            }.items()
        ),
    ],
)
def test_a_film_whose_rate_varies_without_times_is_not_believed(
    changes: Any, tmp_path: Path, capsys: Capsys
) -> None:
    shot = analysed(odd_films.rate_varies(changes, 150), tmp_path, capsys)
    found = [impact["e"] for impact in shot["impacts"]]
    assert all(abs(e["value"] - 0.8) < 3 * e["sigma"] for e in found)
    notes = [note for note in shot["notes"] if "the film's rate varies" in note]
    assert notes
    assert all("frame " in note and " px" in note for note in notes)
    assert len(shot["positions"]["frame"]) > 60


@pytest.mark.long
def test_a_stretch_in_which_the_rate_of_a_film_without_times_holds_gives_its_bounces(
    tmp_path: Path, capsys: Capsys
) -> None:
    def slower(t: NDArray[np.float64]) -> NDArray[np.float64]:
        return t + np.clip(t - 100 / RATE, 0.0, 20 / RATE)

    shot = analysed(odd_films.rate_varies(slower, 300), tmp_path, capsys)
    note = said(shot, "in which its rate holds")
    first = int(note.split("frames ")[2].split()[0])
    assert 110 < first < 130
    assert [is_true(impact, 0.8) for impact in shot["impacts"]] == [True, True]
