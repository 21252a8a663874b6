"""A ball in a tracker's table: e of its bounces, whichever way up and in whatever unit."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.balls.flight.known import Ball
from analysis.balls.tracks.document import track_document
from analysis.balls.tracks.fall import table_fall
from analysis.balls.tracks.measuring import measure_track
from analysis.balls.tracks.table import TrackTable
from analysis.errors import ShotRefusedError
from benchmarks.balls.dropping import GRAVITY, STEP_S, Drop, fly

RATE, DIAMETER, NOISE_M = 120.0, 0.04, 3e-4
E = 0.8
BALL = Ball(DIAMETER, density=1000.0)
DROP = Drop(
    diameter=DIAMETER,
    mass=1000.0 * math.pi / 6.0 * DIAMETER**3,
    drag_coefficient=0.47,
    start=np.array([0.0, 0.9, 0.0]),
    speed=np.array([0.3, 0.0, 0.0]),
    restitution=(E, 0.0, 1.0),
    grip=0.8,
)


def flown(drop: Drop = DROP, lasts_s: float = 1.5) -> Floats:
    """Return places across and up of a ball that bounces, frame by frame, in m with scatter."""
    path = fly(drop, lasts_s)[1]
    each = path[:: round(1.0 / RATE / STEP_S), :2]
    rng = np.random.default_rng(3)
    return np.asarray(each + rng.normal(0.0, NOISE_M, each.shape))


def table(places: Floats, metres: float | None = None) -> TrackTable:
    frames = np.arange(len(places), dtype=float)
    things = np.full(len(places), "0")
    return TrackTable(frames, frames / RATE, places, things, metres, numbered=True, notes=())


def measured(of: TrackTable, rate: float | None = None) -> Any:
    return track_document(measure_track(of, BALL, rate, None))


@pytest.mark.parametrize(
    ("turn", "unit"),
    [
        pytest.param([[1, 0], [0, 1]], 1.0, id="y upwards in m"),
        pytest.param([[1, 0], [0, -1]], 1234.5, id="y downwards in pixels"),
        pytest.param([[0, 1], [1, 0]], 39.37, id="x upwards in inches"),
    ],
)
def test_e_is_that_of_the_flight_whichever_way_up_and_in_any_unit(
    turn: list[list[int]], unit: float
) -> None:
    shot = measured(table(flown() @ np.array(turn) * unit))
    assert len(shot["impacts"]) == 2
    for impact in shot["impacts"]:
        assert impact["e"]["value"] == pytest.approx(E, abs=4 * impact["e"]["sigma"])
        assert impact["e"]["sigma"] < 0.01
    # Fallen from 0.88 m, by Torricelli; the air takes less than a per cent.
    speed = -math.sqrt(2 * GRAVITY * (0.9 - 0.5 * DIAMETER))
    assert shot["impacts"][0]["v_n"]["value"] == pytest.approx(speed, rel=0.01)
    scale = shot["scale_units_per_m"]["from_gravity"]
    assert scale["value"] == pytest.approx(unit, rel=0.02)
    assert "states no unit" in shot["notes"][0]


def test_a_length_that_was_calibrated_wrongly_contradicts_gravity_and_leaves_e() -> None:
    right, wrong, other = (
        measured(table(flown() * share, metres=1.0)) for share in (1.0, 1.3, 800.0)
    )
    assert right["scale_units_per_m"]["agree"]
    for shot in (wrong, other):
        assert not shot["scale_units_per_m"]["agree"]
        assert any("the table's unit contradicts gravity" in note for note in shot["notes"])
    # A ball that seems to fly 1.3 times as far has been measured in units of 1 / 1.3 m.
    said = next(note for note in wrong["notes"] if "contradicts gravity" in note)
    assert "by the fall it is 0.7" in said
    for shot in (right, wrong, other):
        assert len(shot["impacts"]) == 2
        assert shot["impacts"][0]["e"]["value"] == pytest.approx(E, abs=0.01)


def test_the_ball_is_found_among_things_that_stay_and_by_pieces_of_its_track() -> None:
    ball = table(flown())
    rng = np.random.default_rng(5)
    still = rng.normal((0.5, 0.3), NOISE_M, ball.places.shape)
    # A tracker that loses the ball at a bounce goes on with another number.
    pieces = np.where(ball.frames < 60, "4", "9")
    both = replace(
        ball,
        frames=np.concatenate([ball.frames, ball.frames]),
        times_s=np.concatenate([ball.frames, ball.frames]) / RATE,
        places=np.concatenate([still, ball.places]),
        things=np.concatenate([np.full(len(still), "1"), pieces]),
    )
    found = [impact["e"]["value"] for impact in measured(both)["impacts"]]
    assert found == pytest.approx([E, E], abs=0.01)


@pytest.mark.long
def test_a_ball_whose_places_scatter_by_a_large_part_of_its_radius_is_measured() -> None:
    """20 mm at 400 px/m with 1.2 px of scatter, a third of the radius."""
    rate = 240.0
    small = replace(DROP, diameter=0.02, mass=DROP.mass / 8.0, start=np.array([0.0, 1.2, 0.0]))
    step = round(1.0 / rate / STEP_S)
    path = 400.0 * fly(small, 2.15)[1][::step, :2]
    frames = np.arange(len(path), dtype=float)
    off: list[float] = []
    for seed in range(4):
        seen = path + np.random.default_rng(seed).normal(0.0, 1.2, path.shape)
        things = np.full(len(path), "0")
        of = TrackTable(frames, frames * step * STEP_S, seen, things, None, numbered=True, notes=())
        found = measure_track(of, replace(BALL, diameter_m=0.02), None, None)
        assert found.flights.bounces >= 3
        for bounce in range(3):
            e, sigma = found.coefficient(bounce)
            assert sigma < 0.006
            off.append((e - E) / sigma)
    assert np.sqrt(np.mean(np.square(off))) < 1.5


def test_bounces_too_near_one_another_for_the_rate_are_none_and_no_scatter() -> None:
    rate = 24.0
    drop = replace(DROP, start=np.array([0.0, 0.12, 0.0]))
    step = round(1.0 / rate / STEP_S)
    seen = 600.0 * fly(drop, 2.0)[1][::step, :2]
    seen = seen + np.random.default_rng(1).normal(0.0, 0.3, seen.shape)
    frames = np.arange(len(seen), dtype=float)
    of = replace(table(seen), frames=frames, times_s=frames * step * STEP_S)
    with pytest.raises(ShotRefusedError, match="no four places"):
        measured(of)


def test_a_ball_that_is_held_for_longer_than_it_flies_is_measured() -> None:
    places = flown()
    rng = np.random.default_rng(6)
    held = places[0] + rng.normal(0.0, NOISE_M, (300, 2))
    found = [
        impact["e"]["value"] for impact in measured(table(np.vstack([held, places])))["impacts"]
    ]
    assert found == pytest.approx([E, E], abs=0.01)


def test_frames_that_a_table_lacks_cost_no_bounce() -> None:
    whole = table(flown())
    kept = np.ones(len(whole.frames), dtype=bool)
    kept[70:74] = False
    kept[np.random.default_rng(7).random(len(kept)) < 0.2] = False
    some = {name: getattr(whole, name)[kept] for name in ("frames", "times_s", "places", "things")}
    found = [impact["e"]["value"] for impact in measured(replace(whole, **some))["impacts"]]
    assert found == pytest.approx([E, E], abs=0.01)


def test_a_plate_that_leans_pushes_a_ball_aside_which_is_said() -> None:
    level = measured(table(flown(replace(DROP, speed=np.zeros(3)))))
    assert not any("leans by some" in note for note in level["notes"])
    rows = np.arange(121) / RATE - 0.4
    # Dropped on a plate of 8 degrees: without friction it leaves at 16 degrees from the vertical.
    turned, e = math.radians(8.0), 0.9
    came = GRAVITY * 0.4
    left = e * came * math.cos(turned)
    beside = came * math.sin(turned)
    up = left * math.cos(turned) - beside * math.sin(turned)
    aside = left * math.sin(turned) + beside * math.cos(turned)
    fallen = -came * rows - 0.5 * GRAVITY * rows**2
    risen = up * rows - 0.5 * GRAVITY * rows**2
    places = np.stack([np.where(rows < 0, 0.0, aside * rows), np.where(rows < 0, fallen, risen)], 1)
    noise = np.random.default_rng(4).normal(0.0, NOISE_M, places.shape)
    said = [note for note in measured(table(places + noise))["notes"] if "leans by some" in note]
    assert "leans by some 8 degrees" in said[0]


def test_frames_keep_the_table_s_numbers_and_a_stated_rate_goes_before_its_times() -> None:
    later = replace(table(flown()), frames=np.arange(len(flown()), dtype=float) + 1000)
    shot = measured(replace(later, times_s=later.frames), rate=RATE)
    first = shot["impacts"][0]
    assert first["frame"] == pytest.approx(1000 + RATE * 0.425, abs=1.5)
    assert first["contact_time_s"] * RATE == pytest.approx(first["frame"], abs=0.5)
    assert min(first["frames_before"]) >= 1000


def test_times_that_are_rounded_until_several_are_the_same_count_in_their_order() -> None:
    whole = table(flown())
    rows = np.arange(len(whole.frames), dtype=float)
    exact = measured(replace(whole, frames=rows))["impacts"]
    rounded = replace(whole, times_s=np.round(rows / RATE, 2), numbered=False)
    for shot in (measured(rounded), measured(rounded, rate=RATE)):
        assert any("rounded to 0.01 s, and several are the same" in note for note in shot["notes"])
        assert not any("other thing" in note for note in shot["notes"])
        for impact, other in zip(shot["impacts"], exact, strict=True):
            assert impact["e"]["value"] == pytest.approx(other["e"]["value"], abs=1e-3)
    # Numbers that lack, and times that are not those of one rate.
    apart = np.where(rows > 60, rows + 9, rows)
    with pytest.raises(ShotRefusedError, match="are not those of one rate"):
        measured(replace(rounded, times_s=np.round(apart / RATE, 2)))


def test_a_stated_rate_that_the_table_s_times_contradict_is_said() -> None:
    said = "the rate of 240 frames/s that is stated goes before the table's times, by which it is "
    whole = table(flown())
    assert f"{said}120" in measured(whole, rate=2.0 * RATE)["notes"]
    assert not any("goes before" in note for note in measured(whole, rate=RATE)["notes"])


def test_rows_without_frames_and_times_say_that_none_that_lacks_is_seen() -> None:
    shot = measured(replace(table(flown()), times_s=None, numbered=False), rate=RATE)
    assert any("a row that is missing is not seen" in note for note in shot["notes"])


def test_times_that_can_be_no_seconds_ask_for_their_unit_and_a_low_rate_is_said() -> None:
    whole = table(flown())
    assert whole.times_s is not None
    with pytest.raises(ShotRefusedError, match=r"steps of 8.333 .*such as t \(ms\)"):
        measured(replace(whole, times_s=1e3 * whole.times_s))
    few = replace(table(flown()[::12]), numbered=False)
    with pytest.raises(ShotRefusedError, match="; 10 frames/s are few: four places"):
        measured(replace(few, times_s=few.frames / 10.0))


@pytest.mark.parametrize(
    ("times", "said"),
    [(None, "the table has no times"), (np.arange(180.0), "times that are frame numbers")],
)
def test_a_table_without_times_asks_for_the_rate(times: Floats | None, said: str) -> None:
    one = table(flown())
    given = None if times is None else times[: len(one.frames)]
    with pytest.raises(ShotRefusedError, match=f"{said}; state the rate with --fps"):
        measured(replace(one, times_s=given))


def test_one_thing_and_one_flight_beside_the_ball_are_said_as_one() -> None:
    found = measure_track(table(flown()), BALL, None, None)
    notes = track_document(replace(found, others=(1, 1)))["notes"]
    assert "1 other thing in the table flies and bounces too; left out" in notes
    assert any(note.startswith("1 flight of the table meets none") for note in notes)
    notes = track_document(replace(found, others=(2, 2)))["notes"]
    assert "2 other things in the table fly and bounce too; left out" in notes


def test_a_ball_that_only_falls_has_no_bounce_and_what_rests_does_not_fall() -> None:
    with pytest.raises(ShotRefusedError, match="without a second flight"):
        measured(table(flown(lasts_s=0.4)))
    still = np.random.default_rng(1).normal(0.0, NOISE_M, (200, 2))
    with pytest.raises(ShotRefusedError, match=r"nothing in the table falls freely|no four places"):
        measured(table(still))


def test_the_fall_of_a_table_is_gravity_along_its_axis() -> None:
    places = flown()
    fall = table_fall(np.arange(len(places)) / RATE, places)
    assert fall.axis == 1
    assert fall.size == pytest.approx(-GRAVITY, rel=0.05)
