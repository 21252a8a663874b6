"""What pages read of results: once each, and only what a shot tells."""

from __future__ import annotations

from typing import Any

from rigctl.errors import NotFoundError
from rigctl.page.parts.readings import Impact, Readings, rows_of
from rigctl.store import ShotState


class Shot:
    """As much of a record as is looked at."""

    def __init__(self, number: int, state: ShotState = ShotState.ANALYSED, results: int = 1):
        self.id, self.number, self.state, self.results = f"shot-{number}", number, state, results


class Results:
    """Results by shot, and how often they were read."""

    def __init__(self, **known: dict[str, Any]) -> None:
        self.known, self.reads = known, 0

    def result(self, shot: str, number: int) -> dict[str, Any]:
        self.reads += 1
        if shot not in self.known:
            raise NotFoundError("has no such result", part=shot)
        return self.known[shot]


def told(value: float, sigma: float | None = 0.1) -> dict[str, float | None]:
    return {"value": value, "sigma": sigma}


MEASURED = {
    "status": "measured",
    "v_n": told(-2.0),
    "v_s": told(1.0),
    "e": told(0.74, 0.01),
    "beta": told(0.4, None),
}


def test_a_result_is_read_once_until_there_is_another_one() -> None:
    results = Results(**{"shot-1": MEASURED})
    readings = Readings(results)
    first = readings.of([Shot(1)])
    assert readings.of([Shot(1)]) == first
    assert results.reads == 1
    readings.of([Shot(1, results=2)])
    assert results.reads == 2


def test_a_measured_shot_tells_its_coefficients_and_its_incidence() -> None:
    [impact] = Readings(Results(**{"shot-1": MEASURED})).of([Shot(1)])
    assert impact.e == (0.74, 0.01)
    assert impact.incidence == 0.5


def test_a_coefficient_without_an_error_is_not_told() -> None:
    [impact] = Readings(Results(**{"shot-1": MEASURED})).of([Shot(1)])
    assert impact.beta is None


def test_shots_that_are_not_measured_or_cannot_be_read_are_left_out() -> None:
    refused = {"status": "refused", "reason": "nothing seen"}
    readings = Readings(Results(**{"shot-1": refused, "shot-3": MEASURED}))
    shots = [Shot(1), Shot(2), Shot(3), Shot(4, ShotState.REFUSED)]
    assert [impact.number for impact in readings.of(shots)] == [3]


def test_the_rows_of_a_csv_leave_empty_what_a_shot_does_not_tell() -> None:
    heading, row = rows_of([Impact(7, (-2.0, 0.1), None, (0.74, 0.01), None)])
    assert heading[:3] == ["shot", "v_n", "sigma of v_n"]
    assert row == [7, -2.0, 0.1, "", "", 0.74, 0.01, "", ""]
