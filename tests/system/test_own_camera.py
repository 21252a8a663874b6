"""The camera of the guide, taken from its page: fired with, refused when a part of it is wrong."""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rigctl.config import parse
from rigctl.config.loading import default_path, read_toml
from rigctl.daemon import open_daemon
from rigctl.errors import ConfigurationError
from rigctl.settings import ShotSettings
from tests.system.test_documentation import DOCS, needs_shell, perform

GUIDE = DOCS / "how-to" / "add-a-camera.md"
PAGE = GUIDE.read_text(encoding="utf-8")
SETTINGS = ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)


def block(kind: str) -> str:
    found = re.search(rf"^```{kind} lab\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "mycamera.py"
    path.write_text(block("python"))
    yield path
    sys.modules.pop("mycamera", None)


def configured(tmp_path: Path, **changes: Any) -> Any:
    document = read_toml(default_path())
    document["camera"] = tomllib.loads(block("toml"))["camera"] | changes
    document["store"] = {"folder": str(tmp_path / "data")}
    return parse(document, "the guide")


@pytest.mark.usefixtures("module")
def test_the_guides_camera_films_a_shot(tmp_path: Path) -> None:
    with open_daemon(configured(tmp_path)) as daemon:
        token = daemon.rig.arm(SETTINGS, "anna").token
        shot = daemon.rig.fire(token, "key", "body", actor="anna")
        assert (shot.outcome, shot.frames, shot.lost) == ("stored", 65, 0)
        assert daemon.store.frames(shot.id).pixels.shape == (65, 192, 240)
        manifest = daemon.store.folders.manifest(shot.id)
        assert manifest["recording"]["by"] == "camera (my own)"


@pytest.mark.usefixtures("module")
def test_an_error_of_the_camera_is_what_the_operator_reads(tmp_path: Path) -> None:
    with open_daemon(configured(tmp_path, columns=4096)) as daemon:
        token = daemon.rig.arm(SETTINGS, "anna").token
        shot = daemon.rig.fire(token, "key", "body", actor="anna")
        assert (shot.outcome, shot.fired, shot.failure_code) == ("aborted", "no", "device-answer")
        assert "4096 columns, allowed 2048 columns" in shot.failure


@needs_shell
def test_the_guides_table_has_every_member_that_the_program_asks_for(tmp_path: Path) -> None:
    said = perform(GUIDE, tmp_path)
    table = PAGE.partition("A `MemoryCamera`:")[2].partition("\n\n")[2].partition("\n\n")[0]
    for member in re.findall(r"^\| `(\w+)", table, re.MULTILINE):
        assert member in said
    assert "is_recording" in table


@pytest.mark.parametrize(
    ("factory", "words"),
    [("mycamera:absent", "cannot be loaded"), ("nothing.there:f", "cannot be loaded")],
)
@pytest.mark.usefixtures("module")
def test_a_function_that_is_not_there_is_named(tmp_path: Path, factory: str, words: str) -> None:
    with (
        pytest.raises(ConfigurationError, match=words),
        open_daemon(configured(tmp_path, factory=factory)),
    ):
        pass


def test_a_camera_that_lacks_a_method_is_refused_before_anything_moves(
    tmp_path: Path, module: Path
) -> None:
    module.write_text(block("python").replace("def is_recording", "def records"))
    with (
        pytest.raises(ConfigurationError, match="a method is missing"),
        open_daemon(configured(tmp_path)),
    ):
        pass
