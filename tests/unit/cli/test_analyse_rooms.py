"""Films of rooms as they are: exposures set anew, balls held still, shadows on the plate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.unit.cli.falling_ball import RATE, SIZE, Drawn, answer, bouncing, picture, save

HELD = 40
FPS = ("--fps", f"{RATE:.0f}")


def test_a_ball_that_is_held_still_before_it_falls_is_measured_from_its_first_flight(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [40.0 + 0.02 * (k % 3) for k in range(HELD)] + bouncing()
    folder = save(tmp_path / "film", [picture(row) for row in rows])
    shot = answer(capsys, str(folder), *SIZE, *FPS)
    assert len(shot["impacts"]) >= 1
    first = shot["impacts"][0]
    assert first["contact_time_s"] > HELD / RATE
    assert first["e"]["value"] == pytest.approx(0.8, abs=max(4 * first["e"]["sigma"], 0.005))


def brighter(shown: Drawn, gain: float) -> Drawn:
    return np.asarray(np.clip(np.rint(gain * shown), 0, 255), np.uint8)


def test_a_camera_that_sets_its_exposure_anew_in_a_flight_moves_no_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = bouncing()
    gains = np.interp(np.arange(len(rows)), [30, 55], [0.6, 1.2]).tolist()
    shown = [brighter(picture(row), gain) for row, gain in zip(rows, gains, strict=True)]
    shot = answer(capsys, str(save(tmp_path / "film", shown)), *SIZE, *FPS)
    places = shot["positions"]
    off = np.array(places["row_px"]) - np.array(rows)[places["frame"]]
    assert len(off) > 0.8 * len(rows)
    assert np.abs(off).max() < 0.15
    e = shot["impacts"][0]["e"]
    assert e["value"] == pytest.approx(0.8, abs=max(4 * e["sigma"], 0.005))


def test_a_shadow_at_the_plate_is_no_hand(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = bouncing(180)
    lowest = [k for k in range(1, len(rows) - 1) if rows[k - 1] < rows[k] > rows[k + 1]]
    shown = [picture(row).copy() for row in rows[: lowest[1] + 1]]
    for k in range(len(shown) - 4, len(shown)):
        dark = shown[k][205:, 40:80]
        dark[:] = dark // 3
    shot = answer(capsys, str(save(tmp_path / "film", shown)), *SIZE, *FPS)
    assert not [note for note in shot["notes"] if "hand" in note]
    assert len(shot["impacts"]) == 1
