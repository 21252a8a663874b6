import json
from pathlib import Path

import pytest

from rigctl import cli
from rigctl.cli.frames import qualify


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(qualify, "DROPS", 2)
    monkeypatch.setattr(qualify, "SHOTS", 1)
    monkeypatch.setattr(qualify, "DIRECTIONS", ((0.0, 1.0),))


def document(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict:
    assert cli.run(["qualify", *arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["run"] == arguments[0]
    return found


def test_the_drop_gives_gravity_beside_that_of_the_thesis(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    found = document(capsys, "drop", "--method", "thesis", "--out", str(tmp_path))
    assert found["thesis"]["mean_m_per_s2"] == pytest.approx(384.47 * 0.0254, rel=1e-5)
    assert found["thesis"]["deviation_m_per_s2"] == pytest.approx(0.89 * 0.0254, rel=0.02)
    assert found["thesis"]["bias"] == pytest.approx(-0.0038, abs=1e-4)
    assert list(found["methods"]) == ["thesis"]
    assert len(found["methods"]["thesis"]["values_m_per_s2"]) == 2
    assert {path.name for path in tmp_path.iterdir()} == {"drop.png", "drop.svg"}


def test_the_disk_gives_the_angles_of_table_6_2(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    found = document(capsys, "disk", "--method", "thesis", "--out", str(tmp_path))
    printed = [round(100 * angle["relative_error"], 2) for angle in found["thesis"]]
    assert printed == [0.18, 0.08, 0.15, 0.14, 0.18, 0.13, -0.02]
    ours = found["methods"]["thesis"]
    for angle, thesis in zip(ours, found["thesis"], strict=True):
        assert angle["actual_deg"] == pytest.approx(thesis["actual_deg"])
        assert abs(angle["relative_error"]) < abs(5e-4)
    assert (tmp_path / "disk.png").exists()


def test_the_stage_gives_every_way_of_a_method(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    found = document(capsys, "stage", "--method", "thesis", "--out", str(tmp_path))
    ways = [error["way"] for error in found["errors"]]
    assert ways == ["pixel", "thirds", "quarters", "exact", "aht", "sobel", "canny"]
    assert (tmp_path / "stage.svg").exists()


@pytest.mark.long
def test_the_depth_gives_every_velocity_with_and_without_the_mirror(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    found = document(capsys, "depth", "--out", str(tmp_path))
    assert found["thesis"]["e"] == pytest.approx(-0.0085, abs=5e-5)
    (shot,) = found["shots"]
    assert set(shot) == set(found["thesis"])
    assert found["refused"] == []
    for name in ("v_n", "v_n_after", "e"):
        assert 0.0 < abs(shot[name]) < 0.01
    assert (tmp_path / "depth.png").exists()


def test_a_person_gets_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["qualify", "drop", "--method", "thesis"]) == 0
    said = capsys.readouterr().out
    assert "thesis, table 6.1     10      384.47             0.89" in said
    assert "ours, thesis" in said


def test_a_folder_that_cannot_be_written_is_said(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    arguments = ["qualify", "drop", "--method", "thesis", "--out", str(tmp_path / "file" / "out")]
    assert cli.run(arguments) == cli.REFUSED
    assert "choose another folder" in capsys.readouterr().err
