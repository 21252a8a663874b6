"""Bounces that were heard: e from the times between them, with the drag of the air."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from analysis.balls.analysis import FilmJob
from analysis.balls.flight.known import Ball
from analysis.balls.tracks.analysis import NO_CAMERA, analyse_table
from analysis.balls.tracks.bounce_times import (
    BounceTimes,
    bounce_document,
    read_bounce_times,
)
from analysis.balls.tracks.table import is_table_of_bounces
from analysis.errors import InputError, ShotRefusedError
from benchmarks.balls.dropping import Bounce, Drop, fly

PHYPHOX = (
    '"Bounce 0 (s)","Height 0 (m)","Bounce 1 (s)","Height 1 (m)","Energy 1","Bounce 2 (s)"\n'
    "1.5E0,4.0E-1,2.0E0,3.0E-1,7.0E-1,0.0E0\n"
)


LIGHT = Drop(
    diameter=0.05,
    mass=80.0 * np.pi / 6 * 0.05**3,
    drag_coefficient=0.47,
    start=np.array([0.0, 1.0, 0.0]),
    speed=np.zeros(3),
    restitution=(0.9, 0.02, 1.0),
    grip=1.0,
)
"""A hollow ball."""


@cache
def light_bounces() -> list[Bounce]:
    return fly(LIGHT, 3.5)[2]


def test_e_of_a_light_ball_is_that_of_its_flight_through_air() -> None:
    ball = Ball(0.05, density=80.0)
    bounces = light_bounces()
    times = np.array([bounce.time for bounce in bounces])
    found = bounce_document(BounceTimes(times), ball)["impacts"]
    in_vacuum = np.diff(times)[1:] / np.diff(times)[:-1]
    assert len(found) == len(bounces) - 2 >= 3
    for impact, bounce, without in zip(found, bounces[1:-1], in_vacuum, strict=True):
        assert impact["e"]["value"] == pytest.approx(bounce.e, abs=2e-4)
        assert impact["v_n"]["value"] == pytest.approx(-bounce.v_n, rel=1e-3)
        # The air matters: without it e would be lower by more than its error.
        assert bounce.e - without > 0.5 * impact["e"]["sigma"]


def test_errors_of_e_are_those_of_times_that_are_heard_a_millisecond_off() -> None:
    rng = np.random.default_rng(2)
    # In a vacuum times between bounces are in the ratio of e.
    true = np.cumsum([1.0, 0.6, 0.6 * 0.8, 0.6 * 0.8**2])
    ball = Ball(0.02, density=1e6)
    off: list[float] = []
    for _ in range(200):
        times = BounceTimes(true + rng.normal(0.0, 1e-3, len(true)))
        found = [impact["e"] for impact in bounce_document(times, ball)["impacts"]]
        off += [(e["value"] - 0.8) / e["sigma"] for e in found]
    assert 0.85 < np.sqrt(np.mean(np.square(off))) < 1.15


def test_bounces_of_phyphox_are_read_and_one_that_was_not_heard_is_none(tmp_path: Path) -> None:
    path = tmp_path / "Energy.csv"
    path.write_text("\n" + PHYPHOX)
    assert is_table_of_bounces(path)
    assert read_bounce_times(path).times_s.tolist() == [1.5, 2.0]
    assert not is_table_of_bounces(tmp_path / "none.csv")
    # The same with semicolons and decimal commas.
    path.write_text(PHYPHOX.replace(",", ";").replace(".", ","))
    assert read_bounce_times(path).times_s.tolist() == [1.5, 2.0]


def test_a_bounce_that_was_not_heard_parts_those_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "Energy.csv"
    names = ",".join(f"Bounce {k} (ms)" for k in range(6))
    path.write_text(f"{names}\n1000,1600,,2500,2900,3220\n")
    times = read_bounce_times(path)
    assert times.times_s == pytest.approx([1.0, 1.6, np.nan, 2.5, 2.9, 3.22], nan_ok=True)
    (impact,) = bounce_document(times, Ball(0.02, density=1e6))["impacts"]
    assert impact["bounce"] == 4
    assert impact["e"]["value"] == pytest.approx(0.8, abs=1e-3)


def test_an_echo_makes_an_e_beyond_one_whose_error_and_a_sentence_say_so() -> None:
    shot = bounce_document(BounceTimes(np.array([1.0, 1.67, 1.75, 2.21])), Ball(0.04, density=1e3))
    e = shot["impacts"][1]["e"]
    assert e["value"] > 1.0
    assert e["value"] - 1.0 <= e["sigma"]
    assert any("something else was heard" in note for note in shot["notes"])


def test_a_time_that_no_ball_flies_is_refused_with_the_bounces_about_it() -> None:
    with pytest.raises(ShotRefusedError, match="30 s between bounces 0 and 1"):
        bounce_document(BounceTimes(np.array([1.0, 31.0, 58.0])), Ball(0.04))


def test_too_few_bounces_and_bounces_out_of_order_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ShotRefusedError, match="2 bounces heard, and no 3 one after another"):
        bounce_document(BounceTimes(np.array([1.0, 2.0])), Ball(0.04))
    path = tmp_path / "Energy.csv"
    path.write_text("Bounce 0 (s),Bounce 1 (s)\n2.0,1.0\n")
    with pytest.raises(InputError, match="not one after another"):
        read_bounce_times(path)
    path.write_text("Bounce 0 (s),Bounce 1 (s)\n2.0,far\n")
    with pytest.raises(InputError, match="no number"):
        read_bounce_times(path)


def test_of_a_ball_without_a_mass_e_holds_how_light_it_may_be() -> None:
    """A ball for table tennis is a fifth as dense as what is taken where nothing is stated."""
    bounces = light_bounces()
    times = np.array([bounce.time for bounce in bounces])
    for impact, bounce in zip(
        bounce_document(BounceTimes(times), Ball(0.04))["impacts"], bounces[1:-1], strict=True
    ):
        for key, true in (("e", bounce.e), ("v_n", -bounce.v_n)):
            assert abs(impact[key]["value"] - true) < 2.0 * impact[key]["sigma"]


def test_bounces_keep_the_table_s_numbers_and_a_number_that_lacks_was_not_heard(
    tmp_path: Path,
) -> None:
    path = tmp_path / "Energy.csv"
    names = ",".join(f"Bounce {k} (us)" for k in (1, 2, 3, 5))
    path.write_text(f"{names}\n1.0e6,1.6e6,2.08e6,2.9e6\n")
    shot = bounce_document(read_bounce_times(path), Ball(0.02, density=1e6))
    (impact,) = shot["impacts"]
    assert impact["bounce"] == 2
    assert impact["e"]["value"] == pytest.approx(0.8, abs=1e-3)
    assert "bounce 2 of 1 to 5" in shot["notes"][0]
    assert "not heard: 4" in shot["notes"][1]


def test_a_first_bounce_at_0_is_the_start_of_the_clock_and_a_later_one_was_not_heard(
    tmp_path: Path,
) -> None:
    path = tmp_path / "Energy.csv"
    names = ",".join(f"Bounce {k} (s)" for k in range(4))
    path.write_text(f"{names}\n0,0.6,1.08,0\n")
    bounces = read_bounce_times(path)
    assert bounces.times_s.tolist() == [0.0, 0.6, 1.08]
    assert "clock's start" in bounces.notes[0]
    # No ball flies for so long: then it was not heard.
    path.write_text(f"{names}\n0,20.6,21.08,21.46\n")
    bounces = read_bounce_times(path)
    assert bounces.times_s == pytest.approx([np.nan, 20.6, 21.08, 21.46], nan_ok=True)
    assert bounces.notes == ()


def test_a_frame_rate_and_an_exposure_are_said_not_to_count(tmp_path: Path) -> None:
    path = tmp_path / "Energy.csv"
    path.write_text("Bounce 0 (s),Bounce 1 (s),Bounce 2 (s)\n1.0,1.6,2.08\n")
    told, untold = (analyse_table(FilmJob(1, path, Ball(0.02), rate)) for rate in (240.0, None))
    assert NO_CAMERA in told.document["notes"]
    assert NO_CAMERA not in untold.document["notes"]
