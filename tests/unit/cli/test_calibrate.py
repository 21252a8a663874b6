import json
from pathlib import Path

import pytest

from analysis.calibration.calibrate import Calibration
from analysis.calibration.estimate import Estimate
from analysis.campaign import Campaign
from rigctl import cli
from rigctl.cli.frames import calibrate as command

pytestmark = pytest.mark.long


def estimate(value: float, sigma: float) -> Estimate:
    return Estimate(
        "mirror angle",
        value,
        sigma,
        "rad",
        0.02,
        0.0,
        "mirror-angle",
        in_poses=False,
        how="markers",
    )


@pytest.fixture
def answered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand in for the measurement, which has tests of its own."""
    told = (estimate(0.012, 0.003), estimate(0.0, float("inf")))
    monkeypatch.setattr(command, "read_campaign", lambda _: Campaign("nylon", ()))
    monkeypatch.setattr(
        command, "estimated", lambda *_: Calibration(told, (1, 3), {2: "frames: cut short"})
    )


@pytest.mark.usefixtures("answered")
def test_estimates_are_printed_as_one_document(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["calibrate", "nylon", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["used"] == [1, 3]
    assert document["refused"] == [{"shot": 2, "reason": "frames: cut short"}]
    known, unknown = document["estimates"]
    assert (known["value"], known["sigma"], known["found"]) == (0.012, 0.003, True)
    assert known["effect"] == "mirror-angle"
    assert (unknown["value"], unknown["determined"]) == (None, False)


@pytest.mark.usefixtures("answered")
def test_a_person_reads_what_the_shots_show(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["calibrate", "nylon"]) == 0
    said = capsys.readouterr().out
    assert "show it" in said
    assert "do not tell it" in said
    assert "shot 2 left out at frames: cut short" in said


def test_a_folder_that_is_not_there_ends_with_bad_input(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["calibrate", str(tmp_path / "nothing")]) == 2
    assert "no such file or folder" in capsys.readouterr().err
