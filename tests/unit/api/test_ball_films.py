"""Films of one ball in Python: with a diameter, or a campaign's folder that has it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import rigctl
from rigctl import cli
from tests.unit.cli.falling_ball import DIAMETER_MM, ON_A_PLATE, RATE, bouncing, write


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a campaign's folder with a film of a ball on a plate."""
    home = tmp_path_factory.mktemp("ball")
    (home / "campaign.toml").write_text(
        ON_A_PLATE.format(diameter_m=1e-3 * DIAMETER_MM, rate_hz=RATE), "utf-8"
    )
    (home / "shots.csv").write_text("shot,exposure_us\n1,0\n", "utf-8")
    (home / "frames").mkdir()
    write(home / "frames" / "0001", bouncing())
    return home


def test_a_film_of_a_ball_has_its_bounces_in_python_and_is_measured_once(campaign: Path) -> None:
    stated: Any = {"ball_diameter_mm": DIAMETER_MM, "fps": 200, "exposure_us": 0}
    film = campaign / "frames" / "0001"
    shots = rigctl.open(film, **stated).measure()
    table = shots.table()
    assert list(table["shot"]) == [100 + k + 1 for k in range(len(shots))]
    for e, sigma, v_n in zip(table["e"], table["sigma_e"], table["v_n"], strict=True):
        assert abs(e - 0.8) < max(4 * sigma, 0.005)
        assert v_n < 0
    assert np.isnan(np.asarray(table["v_s"])).all()
    assert "restitution" in shots.plot().get_ylabel()
    assert shots.now == 1
    assert rigctl.open(film, **stated).measure().now == 0


@pytest.mark.long
def test_a_campaign_s_folder_says_what_its_films_show_and_is_fitted(campaign: Path) -> None:
    for place in (campaign, campaign / "frames" / "0001"):
        again = rigctl.open(place).measure()
        assert len(again) > 0
        assert list(again.table()["e"]) == pytest.approx([0.8] * len(again), abs=0.01)
    assert again.now == 0
    # Without spin much has no score: it says what would show it.
    ranking = rigctl.open(campaign).fit().rank()
    scores = [row["score"] for row in ranking.to_list()]
    assert None in scores
    for score, why in zip(scores, ranking.table()["why_no_score"], strict=True):
        assert (score is None) == ("not determined" in why)


def test_a_film_of_other_bodies_than_the_thesis_s_asks_for_the_diameter(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    film = write(tmp_path / "film", [100.0] * 6)
    with pytest.raises(rigctl.AnalysisInputError, match="ball_diameter_mm=40"):
        rigctl.open(film).measure()
    assert cli.run(["analyse", str(film)]) == cli.BAD_INPUT
    assert "--ball-diameter-mm 40" in capsys.readouterr().err
    with pytest.raises(rigctl.AnalysisInputError, match="for films of one ball"):
        rigctl.open(film, fps=200)
    with pytest.raises(rigctl.AnalysisInputError, match="no such file"):
        rigctl.open(tmp_path / "nothing.mp4", ball_diameter_mm=40)


def test_a_plate_s_frames_are_measured_by_the_command_as_their_campaign_is(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    black = tmp_path / "frames" / "0001"
    black.mkdir(parents=True)
    for k in range(6):
        cv2.imwrite(str(black / f"{k}.png"), np.full((40, 40), 9, np.uint8))
    for name in ("campaign.toml", "shots.csv"):
        (tmp_path / name).write_bytes((campaign / name).read_bytes())
    assert cli.run(["analyse", str(black)]) == cli.BAD_INPUT
    # It was looked for as one ball, whose diameter is stated: none is there.
    assert "nothing round moves" in capsys.readouterr().err
