"""`rigctl firmware` writes out the box's source, and never over somebody's changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from rigctl.cli import run

SOURCE = Path(__file__).parents[3] / "firmware"


def test_the_source_is_written_whole_with_the_steps_to_flash_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "box"
    assert run(["firmware", "--out", str(out), "--port", "/dev/ttyACM3"]) == 0
    for path in SOURCE.rglob("*"):
        if path.is_file() and "build" not in path.parts:
            assert (out / path.relative_to(SOURCE)).read_bytes() == path.read_bytes()
    printed = capsys.readouterr().out
    assert "flash PORT=/dev/ttyACM3" in printed
    assert "Arduino Nano" in printed


def test_a_changed_file_in_the_folder_is_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "trigger_box.c").write_text("/* mine */")
    assert run(["firmware", "--out", str(tmp_path)]) != 0
    assert (tmp_path / "trigger_box.c").read_text() == "/* mine */"
    assert "choose another folder" in capsys.readouterr().err
