"""Films of one ball in Python, of which it is known what was measured of each."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rigctl
from analysis.balls.analysis import FilmJob
from analysis.exchange.shot_list import EXCLUDED, ShotRow
from rigctl.api import opening
from rigctl.api.shots import Shots
from rigctl.measuring.ball_films import BallFilms
from rigctl.measuring.own_film import stated_ball
from tests.unit.cli.falling_ball import ON_A_PLATE

GRAVITY, RESTITUTION, CAME = 9.80665, 0.8, 2.0
DESCRIBED = ON_A_PLATE.format(diameter_m=0.04, rate_hz=240.0)


def bounce(sigma_e: float = 0.001, **poses: Any) -> dict[str, Any]:
    """Return the document of a ball that comes with 2 m/s and leaves with 1.6 m/s."""
    times = np.arange(-20, 21) / 240.0 + 0.002
    speed = np.where(times < 0, CAME, -RESTITUTION * CAME)
    places = speed * times + 0.5 * GRAVITY * times**2
    return {
        "status": "measured",
        "notes": [],
        "impacts": [
            {
                "v_n": {"value": -CAME, "sigma": 0.01, "unit": "m/s"},
                "v_n_after": {"value": RESTITUTION * CAME, "sigma": 0.008, "unit": "m/s"},
                "e": {"value": RESTITUTION, "sigma": sigma_e, "unit": "1"},
            }
        ],
        "poses": {
            "frame": list(range(len(times))),
            "t_s": times.tolist(),
            "x_m": places.tolist(),
            "y_m": [0.0] * len(times),
            "sigma_x_m": [2e-5] * len(times),
            "sigma_y_m": [2e-5] * len(times),
            "normal": [1.0, 0.0, 0.0],
            "scale_px_per_m": 1000.0,
            "scale_sigma": 0.001,
            "slow_m": 1e-5,
            **poses,
        },
    }


def measured(
    monkeypatch: pytest.MonkeyPatch, documents: list[dict[str, Any]], excluded: int | None = None
) -> tuple[Shots, Any]:
    """Return the shots of films that these documents are the results of, and their data."""
    monkeypatch.setattr(opening, "_measured", lambda job: documents[job.shot - 1])
    numbers = range(1, len(documents) + 1)
    jobs = [FilmJob(k, Path(f"none-{k}.mp4"), stated_ball(40.0, 2.7), 240.0) for k in numbers]
    rows = [ShotRow(k, None, {}, {EXCLUDED: "yes"} if k == excluded else {}) for k in numbers]
    found = opening.FilmedBall(BallFilms("drops", jobs, rows)).measured(None)
    return Shots("drops", found), found.data


@pytest.mark.parametrize("sigma_e", [0.0, 0.001, 0.0113, 0.25])
def test_e_is_as_uncertain_in_the_table_as_the_film_s_own_result_says(
    sigma_e: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = measured(monkeypatch, [bounce(sigma_e)])[0].table()
    assert list(table["e"]) == pytest.approx([RESTITUTION])
    # Two speeds whose errors are as large as these leave e exact where they err alike.
    assert list(table["sigma_e"]) == pytest.approx([sigma_e], abs=1e-6)
    assert list(table["sigma_v_n"]) == pytest.approx([0.01])


def test_a_film_that_a_person_excluded_changes_no_error_of_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bad = bounce(scale_sigma=0.3, slow_m=0.01, normal=[0.8, 0.6, 0.0])
    shots, data = measured(monkeypatch, [bounce(), bad], excluded=2)
    assert shots.left_out == {2: "a person excluded it"}
    assert (data.slow.scale, data.slow.position_m) == (0.001, 1e-5)
    assert data.plate.normal == (1.0, 0.0, 0.0)


def test_a_bounce_of_which_poses_are_too_few_is_left_out_or_measured_not_both(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    few = {key: bounce()["poses"][key][19:22] for key in ("frame", "t_s", "x_m", "y_m")}
    few |= {key: [2e-5] * 3 for key in ("sigma_x_m", "sigma_y_m")}
    unseen = bounce(**few) | {"impacts": []}
    shots, data = measured(monkeypatch, [bounce(), bounce(**few), unseen])
    assert set(data.unusable) == {201, 301}
    assert list(shots.table()["shot"]) == [101, 201]
    assert list(shots.left_out) == [301]
    assert "the sphere free before its bounce" in shots.left_out[301]


def test_a_corrected_header_of_a_photron_film_is_another_film(tmp_path: Path) -> None:
    raw, header = tmp_path / "a.mraw", tmp_path / "a.cihx"
    raw.write_bytes(b"pictures")
    keys = set()
    for text in ("<recordRate>1000</recordRate>", "<recordRate>2000</recordRate>"):
        header.write_text(text, "utf-8")
        keys |= {opening._key(FilmJob(1, one, stated_ball(40.0, None))) for one in (raw, header)}
    assert len(keys) == 4
    raw.write_bytes(b"others")
    assert opening._key(FilmJob(1, header, stated_ball(40.0, None))) not in keys


def test_films_of_unlike_balls_are_refused_and_both_named(tmp_path: Path) -> None:
    for name, diameter in (("small", 0.02), ("large", 0.04)):
        frames = tmp_path / name / "frames"
        frames.mkdir(parents=True)
        described = ON_A_PLATE.format(diameter_m=diameter, rate_hz=240.0)
        (tmp_path / name / "campaign.toml").write_text(described, "utf-8")
        (tmp_path / name / "shots.csv").write_text("shot\n1\n", "utf-8")
        (frames / "0001.mp4").write_bytes(b"film")
    places = [tmp_path / name for name in ("small", "large")]
    with pytest.raises(rigctl.AnalysisInputError, match=r"40 mm and .* 20 mm and ") as refused:
        rigctl.open(places)
    assert str(places[0]) in str(refused.value)
    assert str(places[1]) in str(refused.value)
    rigctl.open(places, ball_diameter_mm=30)


def test_a_folder_of_loose_films_with_a_plate_s_set_up_is_its_films(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    films = tmp_path / "drops"
    films.mkdir()
    # Of every kind that is read; Photron's header belongs to the frames beside it.
    for name in ("a.avi", "b.MOV", "c.cine", "d.mraw", "d.cihx", "e.webm"):
        (films / name).write_bytes(b"film")
    (tmp_path / "plate.toml").write_text(DESCRIBED, "utf-8")
    monkeypatch.setattr(opening, "_measured", lambda _: bounce())
    shots = rigctl.open(films, setup=tmp_path / "plate.toml").measure()
    assert list(shots.table()["shot"]) == [101, 201, 301, 401, 501]
    assert shots.name == "drops"


def test_a_diameter_that_poses_do_not_need_is_to_be_left_out(tmp_path: Path) -> None:
    (tmp_path / "campaign.toml").write_text(DESCRIBED, "utf-8")
    (tmp_path / "poses.csv").write_text("", "utf-8")
    with pytest.raises(rigctl.AnalysisInputError, match="leave them out: this holds tables"):
        rigctl.open(tmp_path, ball_diameter_mm=40)
