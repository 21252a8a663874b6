"""`rigctl config check`: every fault of a configuration in one sentence, before a device opens."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rigctl.cli import BAD_INPUT, run

CONFIGURATIONS = Path(__file__).parents[3] / "config"


def test_the_configurations_that_come_with_it_have_no_fault(
    capsys: pytest.CaptureFixture[str],
) -> None:
    files = sorted(map(str, CONFIGURATIONS.glob("*.toml")))
    assert run(["config", "check", *files]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(files)
    real = [line for line in lines if "REAL RIG" in line]
    assert [Path(line.partition(":")[0]).stem for line in real] == ["pusher", "release"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "frame_rate_hz = 1000.0",
            "frame_rate_hz = -5",
            ["camera.frame_rate_hz", "found -5 Hz", "more than 0.0 Hz", "correct it"],
        ),
        ("port = 8486", "prot = 8486", ["service.prot", "did you mean port?"]),
        ('host = "127.0.0.1"', 'host = "0.0.0.0"', ["service.host", "listen on 127.0.0.1"]),
        ("[camera]", "[camera", ["not TOML", "line"]),
    ],
)
def test_a_fault_is_named_with_file_key_value_unit_limit_and_what_to_do(
    old: str, new: str, said: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (CONFIGURATIONS / "pusher.toml").read_text("utf-8")
    assert old in text
    rig = tmp_path / "my-rig.toml"
    rig.write_text(text.replace(old, new), "utf-8")
    sound = str(CONFIGURATIONS / "simulated.toml")
    assert run(["config", "check", str(rig), sound]) == BAD_INPUT
    shown = capsys.readouterr()
    assert all(words in shown.err for words in [str(rig), *said])
    assert "Traceback" not in shown.err
    # The others are looked at all the same.
    assert f"{sound}: no fault" in shown.out


def test_every_fault_of_a_file_has_a_line_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (CONFIGURATIONS / "pusher.toml").read_text("utf-8")
    rig = tmp_path / "my-rig.toml"
    rig.write_text(
        text.replace("frame_rate_hz = 1000.0", "frame_rate_hz = -5").replace("port = ", "prot = "),
        "utf-8",
    )
    assert run(["config", "check", str(rig), "--json"]) == BAD_INPUT
    shown = capsys.readouterr()
    (found,) = json.loads(shown.out)["files"]
    assert found["rig"] is None
    parts = [fault["part"] for fault in found["faults"]]
    assert any("camera.frame_rate_hz" in part for part in parts)
    assert len(parts) == len(shown.err.splitlines()) > 1
    assert run(["config", "check", str(tmp_path / "nothing.toml")]) == BAD_INPUT
    assert "no such file" in capsys.readouterr().err
