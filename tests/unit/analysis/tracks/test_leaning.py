"""A ball on a plate that leans: e along its normal, and the lean itself, by where bounces are."""

from __future__ import annotations

import math

import numpy as np
import pytest

from analysis.balls.flight.known import Ball, plate_lean
from analysis.balls.tracks.document import track_document
from analysis.balls.tracks.measuring import MeasuredTrack, measure_track
from analysis.balls.tracks.table import TrackTable
from analysis.setup import CameraSetup, Environment, Setup, SphereSetup
from benchmarks.balls.dropping import GRAVITY

E, ALONG = 0.75, 0.8
RATE, SCATTER_M = 240.0, 4e-4
BALL = Ball(0.04, density=7800.0, air_density=1e-3)


def bounced(lean: float, lasts_s: float, turned: float = 0.0) -> TrackTable:
    """Return places across and up, m, of a ball in a vacuum that falls on a plate that leans.

    In axes along the plate and its normal both flights are parabolas (textbook): the ball comes
    back after twice its speed over g cos(lean), and speeds up along the plate by g sin(lean).

    Parameters
    ----------
    lean
        Angle of the plate, rad, positive where it lies lower on the right.
    turned
        Angle by which the camera is rolled, rad.
    """
    down, along = GRAVITY * math.cos(lean), GRAVITY * math.sin(lean)
    height = 0.7 * math.cos(lean)
    times = np.arange(round(RATE * lasts_s)) / RATE
    places = np.empty((len(times), 2))
    contact, begun = math.sqrt(2 * height / down), 0.0
    place, speed, up, rise = 0.0, 0.2, height, 0.0
    for k, t in enumerate(times):
        while t > contact:
            lasts = contact - begun
            place, speed = place + speed * lasts + along * lasts**2 / 2, speed + along * lasts
            rise, up, speed, begun = E * (down * lasts - rise), 0.0, ALONG * speed, contact
            contact = begun + 2 * rise / down
        s = t - begun
        places[k] = place + speed * s + along * s**2 / 2, up + rise * s - down * s**2 / 2
    angle = turned - lean
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    seen = places @ turn.T + np.random.default_rng(7).normal(0.0, SCATTER_M, places.shape)
    frames = np.arange(len(seen), dtype=float)
    things = np.full(len(seen), "0")
    return TrackTable(frames, frames / RATE, seen, things, 1.0, numbered=True, notes=())


def measured(
    table: TrackTable, ball: Ball = BALL
) -> tuple[MeasuredTrack, list[tuple[float, float]]]:
    found = measure_track(table, ball, None, None)
    return found, [found.coefficient(bounce) for bounce in range(found.flights.bounces)]


def notes(found: MeasuredTrack) -> str:
    return "; ".join(track_document(found)["notes"])


@pytest.mark.parametrize("degrees", [3.0, -15.0, 30.0])
def test_several_bounces_show_how_a_plate_leans(degrees: float) -> None:
    found, coefficients = measured(bounced(math.radians(degrees), 1.3))
    assert len(coefficients) >= 2
    for e, sigma in coefficients[:2]:
        assert e == pytest.approx(E, abs=4 * sigma)
        assert sigma < 0.01
    flights = found.flights
    assert flights.lean == pytest.approx(math.radians(degrees), abs=4 * flights.lean_sigma)
    assert flights.lean_sigma < math.radians(0.5)
    assert "lower on the right" in notes(found) if degrees > 0 else "left" in notes(found)


def test_a_camera_that_is_rolled_over_a_level_floor_shows_no_lean() -> None:
    found, coefficients = measured(bounced(0.0, 1.3, turned=math.radians(3.0)))
    assert not found.flights.leans
    assert "leans" not in notes(found)
    for e, sigma in coefficients:
        assert e == pytest.approx(E, abs=4 * sigma)


def test_of_one_bounce_the_lean_is_that_which_is_stated() -> None:
    lean = math.radians(15.0)
    table = bounced(lean, 0.62)
    unsaid, (off,) = measured(table)
    assert abs(off[0] - E) > 10 * off[1]
    assert "or the surface leans by some" in notes(unsaid)
    stated, ((e, sigma),) = measured(table, Ball(0.04, density=7800.0, plate_lean=lean))
    assert e == pytest.approx(E, abs=4 * sigma)
    assert "leans" not in notes(stated)


def test_a_stated_normal_says_how_the_plate_leans() -> None:
    """A plate that lies lower on the right has its normal into it downward and to the left."""

    def said(normal: tuple[float, float, float] | None) -> float | None:
        spheres = SphereSetup("a", 0.04), SphereSetup("b", plate=True, normal=normal)
        return plate_lean(Setup(CameraSetup(RATE, 480, 640), spheres, Environment()))

    slope = math.radians(15.0)
    assert said((math.cos(slope), -math.sin(slope), 0.0)) == pytest.approx(slope)
    assert said((2.0, 0.0, 0.0)) == 0.0
    assert said(None) is None
