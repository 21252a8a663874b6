"""The plane of a sweep: what it covers, and what became of its steps."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any
from urllib.parse import parse_qs, urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.config import load
from rigctl.page.parts.readings import Impact, turns_until
from rigctl.page.sweeps.form import form_address, grid_words
from rigctl.page.sweeps.pages import how_far, what_became
from rigctl.page.sweeps.plots import LOOKS, covers, grid, incidence, legend, progress
from rigctl.settings import ShotSettings
from rigctl.store import ShotState, StepState
from rigctl.sweeps.form import Grid, Sweep

LIMITS = load().limits


def settings(pressure: float, offset: float) -> ShotSettings:
    return ShotSettings(pressure_a_kpa=pressure, pressure_b_kpa=pressure, offset_mm=offset)


@given(st.floats(0, math.radians(85)))
def test_the_incidence_is_the_tangent_of_the_angle_between_flight_and_normal(angle: float) -> None:
    assert incidence(25.4 * math.sin(angle)) == pytest.approx(math.tan(angle), abs=1e-9)


GRAZING = settings(40, 25.4 * math.sin(math.pi / 4))


def test_what_a_sweep_covers_is_said_from_its_least_to_its_largest_offset() -> None:
    said = covers([settings(40, 0), GRAZING])
    assert said == "2 shots, sliding ÷ approach from about 0.00 to 1.00"
    # The ratio does not depend on the pressure.
    assert covers([settings(80, 0), GRAZING]) == said


def measured(ratio: float, mu: float, e: float = 0.74, beta0: float = 0.5) -> Impact:
    """Return a shot of Walton's law for solid spheres: what friction can turn round it does."""
    after = max(-beta0 * ratio, ratio - 3.5 * mu * (1 + e))
    return Impact(1, (-2.0, 0.01), (2.0 * ratio, 0.01), (e, 0.01), (-after / ratio, 0.01))


@given(st.floats(0.04, 0.15))
def test_the_shots_measured_here_say_until_where_friction_turns_the_sliding_round(
    mu: float,
) -> None:
    step = 0.05
    shots = [measured(step * k, mu) for k in range(1, 41)]
    found = turns_until(shots)
    assert found == pytest.approx(3.5 * mu * 1.74, abs=step)
    said = covers([settings(40, 0), GRAZING], found)
    assert said.endswith(
        f"; in 1 friction turns the sliding round, as in the shots measured here up to {found:.2f}"
    )
    assert turns_until(shots[:2]) is None
    assert turns_until([measured(0.01 * k, mu) for k in range(1, 10)]) is None


def test_a_setting_that_is_repeated_is_one_point_that_says_how_often() -> None:
    points = grid([settings(40, 6), settings(40, 6), settings(60, 6)], LIMITS)["data"][0]
    assert list(zip(points["x"], points["y"], points["customdata"], strict=True)) == [
        (40, 6, 2),
        (60, 6, 1),
    ]


def test_fates_are_told_apart_by_form_and_not_by_colour_alone() -> None:
    forms = {
        (look.get("symbol", "circle"), look["color"] == "rgba(0,0,0,0)") for look in LOOKS.values()
    }
    assert len(forms) == len(LOOKS)


def test_the_legend_is_the_same_whatever_became_of_the_steps() -> None:
    early = progress({"waiting": [(1, settings(40, 6))]}, LIMITS)
    late = progress({"measured": [(1, settings(40, 6))], "skipped": []}, LIMITS)
    names = [
        [trace["name"] for trace in drawn["data"] if "name" in trace] for drawn in (early, late)
    ]
    assert names == [list(LOOKS), list(LOOKS)]
    assert early["layout"] == late["layout"]
    assert "showlegend" not in early["layout"] or not early["layout"]["showlegend"]
    for counts in ({}, {"measured": 20, "skipped": 3}):
        said = legend(counts)
        assert [said.count(f"{counts.get(name, 0)} {name}<") for name in LOOKS] == [1] * len(LOOKS)


def test_only_fates_that_occur_are_drawn() -> None:
    drawn = progress({"measured": [(1, settings(40, 6))], "waiting": []}, LIMITS)["data"]
    assert {trace.get("name"): trace["x"] for trace in drawn if trace["x"] != [None]} == {
        "measured": [40]
    }


@pytest.mark.parametrize(
    ("step", "shot", "fate"),
    [
        (StepState.WAITING, None, "waiting"),
        (StepState.SKIPPED, None, "skipped"),
        (StepState.TAKEN, None, "being fired"),
        (StepState.STORED, None, "being measured"),
        (StepState.STORED, ShotState.STORED, "being measured"),
        (StepState.STORED, ShotState.ANALYSED, "measured"),
        (StepState.STORED, ShotState.REFUSED, "not measured"),
        (StepState.LOST, ShotState.ABORTED, "not measured"),
        (StepState.NOT_FIRED, None, "not measured"),
        (StepState.UNKNOWN, ShotState.UNKNOWN_OUTCOME, "not measured"),
    ],
)
def test_every_state_of_a_step_has_a_fate_that_is_drawn(
    step: StepState, shot: ShotState | None, fate: str
) -> None:
    record = None if shot is None else SimpleNamespace(state=shot)
    assert what_became(SimpleNamespace(state=step), record) == fate
    assert fate in LOOKS


def test_proposed_shots_come_back_from_the_address_as_they_were() -> None:
    proposed = Sweep.model_validate(
        {"note": "tells a from b & c?", "shots": [{**settings(40, 6).model_dump(), "repeat": 3}]}
    )
    asked = parse_qs(urlsplit(form_address(proposed)).query)["form"][0]
    assert Sweep.model_validate_json(asked) == proposed


def test_a_proposed_grid_is_said_by_the_ends_of_its_settings() -> None:
    levels = {"pressure_a_kpa": {"first": 20, "last": 80, "count": 5}, "offset_mm": [6]}
    said = grid_words(Grid.model_validate(levels))
    assert said == "Pressure a 20 to 80 kPa (5 values), Offset 6 mm (1 value)"


def test_shots_that_were_fired_are_counted_apart_from_those_that_could_not_be() -> None:
    counts = {StepState.STORED: 2, StepState.NOT_FIRED: 1, StepState.WAITING: 3}
    status: Any = SimpleNamespace(record=SimpleNamespace(steps=6, counts=counts), left_s=None)
    assert how_far(status) == (3, 6, "2 of 6 shots fired, 1 could not be")
