"""`rigctl analyse` of films that a program brought to a lower rate by leaving pictures out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.unit.cli.falling_ball import RATE, SIZE, answer, bouncing, picture, save

TAKEN = 5
"""Of the drawn pictures the camera takes each so many: forty a second."""


@pytest.mark.parametrize(("kept", "of"), [(5, 6), (2, 5)])
def test_a_film_that_leaves_pictures_out_is_measured_at_the_times_of_those_it_shows(
    kept: int, of: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As from 30 to 25 frames/s, and from 60 to 24."""
    taken = TAKEN if kept == 5 else TAKEN // 2
    rows = bouncing(taken * 96)[::taken]
    which = [k * of // kept for k in range(96 * kept // of)]
    columns = [20.0 + 80.0 * n / 96 for n in which]
    drawn = [picture(rows[n], column) for n, column in zip(which, columns, strict=True)]
    film = save(tmp_path / "film", drawn)
    rate = RATE / taken * kept / of
    shot = answer(capsys, str(film), *SIZE, "--fps", f"{rate:.6f}")
    assert shot["status"] == "measured", shot
    (note,) = [each for each in shot["notes"] if "lower rate" in each]
    assert f"shows {len(which)} of {which[-1] + 1}" in note
    told = float(note.split("camera's pictures, ")[1].split(" a second")[0])
    assert told == pytest.approx(RATE / taken, rel=0.003)
    assert not any("missing" in each for each in shot["notes"])
    found = [impact["e"] for impact in shot["impacts"]]
    assert found
    assert [e for e in found if not abs(e["value"] - 0.8) < 4 * e["sigma"] < 0.06] == []
    frames, times = (shot["positions"][name] for name in ("frame", "t_s"))
    steps = np.diff(times) * RATE / taken
    assert steps == pytest.approx(np.diff(np.array(which)[frames]), rel=0.01)
