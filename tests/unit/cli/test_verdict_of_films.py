"""From drawn films of a bouncing ball to a verdict: `rigctl analyse --out`, `rigctl model explain`.

Ball, air and restitution are drawn by a law that the analysis does not see.
"""

from __future__ import annotations

import io
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rigctl import cli
from tests.unit.cli.falling_ball import DIAMETER_MM, FALL, RATE, write

PX_PER_M = FALL / 9.80665
MASS_G, DRAG = 60.0, 0.47
"""A hollow ball of 98 mm, whose flights the air bends."""
FLOOR_PX, STEP_S = 220.0, 2e-6
LASTING_S = 1.6
SPEED_LAWS = {"restitution-viscoelastic", "restitution-plastic", "restitution-yield-knee"}


def restitution(speed: float) -> float:
    """Fall with the speed as a power of it: 0.80 at 2 m/s."""
    return float(0.80 * (speed / 2.0) ** -0.12)


def places_of_fall(height_px: float, drift_px: float) -> tuple[list[float], list[float]]:
    """Return the ball's rows and columns in each frame, m and s stepped finely.

    Drag brakes what it drifts across, px a frame, as it brakes the fall; bounces do not.
    """
    drag = 0.5 * 1.2 * DRAG * np.pi / 4 * (1e-3 * DIAMETER_MM) ** 2 / (1e-3 * MASS_G)
    down, speed, rows = -height_px / PX_PER_M, 0.0, []
    beside, across, columns = 0.0, drift_px * RATE / PX_PER_M, []
    each = round(1.0 / RATE / STEP_S)
    for step in range(int(LASTING_S / STEP_S)):
        if step % each == 0:
            rows.append(FLOOR_PX + PX_PER_M * down)
            columns.append(40.0 + PX_PER_M * beside)
        braking = drag * math.hypot(speed, across)
        change, slower = 9.80665 - braking * speed, -braking * across
        down += STEP_S * (speed + 0.5 * STEP_S * change)
        beside += STEP_S * (across + 0.5 * STEP_S * slower)
        speed, across = speed + STEP_S * change, across + STEP_S * slower
        if down > 0.0 and speed > 0.0:
            speed *= -restitution(speed)
            down = 0.0
    return rows, columns


def printed(arguments: list[str]) -> Any:
    """Return the document that a command prints."""
    with pytest.MonkeyPatch.context() as patch, io.StringIO() as file:
        patch.setattr("sys.stdout", file)
        assert cli.run([*arguments, "--json"]) == 0
        return json.loads(file.getvalue())


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    """Folder of a campaign of three films, and what their analysis printed."""
    folder = tmp_path_factory.mktemp("films")
    films = []
    for number, height in enumerate((170.0, 110.0, 60.0), start=1):
        places = places_of_fall(height, 0.06 * number)
        films.append(str(write(folder / str(number), *places)))
    ball = ["--ball-diameter-mm", f"{DIAMETER_MM:.3f}", "--ball-mass-g", f"{MASS_G}"]
    camera = ["--fps", f"{RATE:g}", "--exposure-us", "0"]
    out = folder / "campaign"
    return out, printed(["analyse", *films, *ball, *camera, "--out", str(out)])


@pytest.fixture(scope="module")
def verdict(campaign: tuple[Path, Any]) -> dict[str, Any]:
    return dict(printed(["model", "explain", str(campaign[0])]))


@pytest.mark.long
@pytest.mark.timeout(600)
def test_each_bounce_of_a_film_is_measured_however_low_it_is(campaign: tuple[Path, Any]) -> None:
    shots = campaign[1]["shots"]
    bounces = [shot["impacts"] for shot in shots]
    # Those after which the ball is still seen high enough.
    assert [len(each) for each in bounces] == [3, 5, 6]
    for impact in (one for each in bounces for one in each):
        e, speed = impact["e"], abs(impact["v_n"]["value"])
        assert abs(e["value"] - restitution(speed)) < 4 * e["sigma"]


@pytest.mark.long
@pytest.mark.timeout(600)
def test_films_of_a_ball_end_in_restitution_that_falls_with_speed(verdict: dict[str, Any]) -> None:
    # Which of them, a dozen bounces may leave open.
    assert verdict["verdict"] in {"effect", "alias"}
    first, *further = verdict["effects"]
    assert first in SPEED_LAWS
    assert set(verdict["alias_set"]) <= SPEED_LAWS
    assert further == []
    assert verdict["chi2_per_dof"] < 1.3
    e = verdict["parameters"]["e"]
    assert abs(named_restitution(verdict, 2.0) - restitution(2.0)) < max(4 * e["sigma"], 0.01)


def named_restitution(verdict: dict[str, Any], speed: float) -> float:
    """Return e at a speed, m/s, by the formula that the verdict states."""
    name = verdict["effects"][0]
    formula, e0 = verdict["formulas"][name], verdict["parameters"]["e"]["value"]
    power = verdict["parameters"][f"{name}.p"]["value"]
    held = re.search(r"v\w+ = ([\d.]+) m/s", formula)
    assert held is not None, formula
    least = 1.0 if name == "restitution-yield-knee" else 0.0
    return float(e0 * max(least, speed / float(held.group(1))) ** -power)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_films_of_a_ball_name_the_drag_of_the_air(verdict: dict[str, Any]) -> None:
    named = {one["nuisance"]: one["found"] for one in verdict["nuisances"]}
    drag = named["drag.Cd"]
    assert drag["sigma"] < 0.05
    assert abs(drag["value"] - DRAG) < 4 * drag["sigma"]
