from __future__ import annotations

import subprocess
import sys
import tomllib
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import httpx
import pytest
import typer

from rigctl import cli
from rigctl import local as local_module
from rigctl.cli.lazy import Command
from rigctl.cli.rig import shot as shot_module
from rigctl.cli.rig.shot import rounded, settings_of
from rigctl.client import ServiceClient
from rigctl.config import default_path
from rigctl.errors import (
    ConfigurationError,
    DeviceError,
    IdempotencyError,
    InterlockError,
    KeyRunningError,
    NotFoundError,
    RefusedError,
    RigError,
    SettingsError,
    StoreError,
)
from rigctl.service.keyfile import ServiceAddress
from rigctl.service.problems import answer, from_error

SETTINGS = settings_of(None, pressure_a_kpa=40, pressure_b_kpa=40, offset_mm=6, angle_a_deg=None)
HEAVY = ("numpy", "cv2", "fastapi", "pydantic", "sqlalchemy", "httpx", "rich", "uvicorn", "scipy")


def test_help_loads_nothing_heavy() -> None:
    program = (
        "import sys\nfrom rigctl.cli import run\nassert run(['--help']) == 0\n"
        f"print(sorted(set({HEAVY}) & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_film_s_numbers_load_no_figures_and_no_statistics_of_a_library() -> None:
    program = (
        "import sys\nfrom rigctl.cli import run\nassert run(['analyse', '--help']) == 0\n"
        "print(sorted({'matplotlib', 'scipy.stats'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run([]) == 0
    shown = capsys.readouterr().out
    for command in ("serve", "shot"):
        assert f"\n  {command} " in shown


def every_command() -> list[list[str]]:
    words: list[list[str]] = []
    for name, entry in cli.COMMANDS.items():
        below = [] if isinstance(entry, Command) else [[name, each] for each in entry.commands]
        words += below or [[name]]
    return words


@pytest.mark.parametrize("words", every_command(), ids=" ".join)
def test_every_command_of_the_table_is_there_and_says_what_the_table_says(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run([*words, "--help"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    entry: Any = cli.COMMANDS[words[0]]
    assert f"Usage: rigctl {' '.join(words)} " in shown
    assert (entry if len(words) == 1 else entry.commands[words[1]]).help in shown


BAD_INPUT = [
    (["frobnicate"], "frobnicate"),
    (["shot", "--offset-mm", "6"], "--pressure-kpa"),
    (["shot", "--pressure-kpa", "much", "--offset-mm", "6"], "--pressure-kpa"),
    (["shot", "--pressure-kpa", "nan", "--offset-mm", "6"], "pressure_a_kpa"),
    (["shot", "--pressure-kpa", "-1", "--offset-mm", "6"], "pressure_a_kpa"),
    (["shot", "--pressure-kpa", "40", "--offset-mm", "inf"], "offset_mm"),
    (["shot", "--pressure-kpa", "40", "--offset-mm", "6", "--wait-s", "-1"], "--wait-s"),
    (["serve", "--port", "70000"], "--port"),
    (["serve", "--config", "/nowhere/rig.toml"], "/nowhere/rig.toml"),
]


@pytest.mark.parametrize("pressure", ["-3", "5000"])
def test_a_setting_beyond_physics_is_refused_with_the_limits_of_the_rig(
    pressure: str, capsys: pytest.CaptureFixture[str]
) -> None:
    low, high = tomllib.loads(default_path().read_text())["limits"]["pressure_kpa"]
    assert cli.run(["shot", "--pressure-kpa", pressure, "--offset-mm", "6"]) == 2
    said = capsys.readouterr().err
    assert f"outside the rig's limits (found {pressure} kPa, allowed {low:g} to {high:g}" in said


@pytest.mark.parametrize(("arguments", "named"), BAD_INPUT)
def test_bad_input_is_one_sentence_and_code_2(
    arguments: list[str], named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    assert named in shown.err


@pytest.mark.parametrize("local", [True, False])
@pytest.mark.parametrize("name", ["../x", "", ".hidden", "x" * 65, "two words", "x\n"])
def test_a_campaign_that_cannot_be_a_folder_is_refused_before_anything_is_armed(
    name: str, local: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("a rig was opened")

    monkeypatch.setattr(local_module, "opened", never)
    monkeypatch.setattr(shot_module, "connected", never)
    arguments = ["shot", "--pressure-kpa", "40", "--offset-mm", "6", "--campaign", name]
    assert cli.run([*arguments, "--local"] if local else arguments) == 2
    shown = capsys.readouterr()
    assert (shown.out, shown.err.count("\n")) == ("", 1)
    assert shown.err.startswith(f"rigctl: campaign: is not a campaign's name (found {name!r}")


CODES = [
    (RefusedError("no"), 3),
    (InterlockError("no"), 3),
    (DeviceError("broken"), 3),
    (StoreError("full"), 3),
    (NotFoundError("none"), 4),
    (ConfigurationError("wrong"), 2),
    (SettingsError("too much"), 2),
    (RigError("what"), 1),
]


@pytest.mark.parametrize(("error", "code"), CODES)
def test_each_kind_of_failure_has_its_exit_code(
    error: RigError, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(shot_module, "connected", fail)
    assert cli.run(["shot", "--pressure-kpa", "40", "--offset-mm", "6"]) == code
    assert str(error) in capsys.readouterr().err


@pytest.mark.parametrize(("cause", "code"), [(EOFError, 2), (KeyboardInterrupt, 130)])
def test_a_question_that_nobody_answers_ends_in_a_sentence(
    cause: type[BaseException],
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def asked(*_: object, **__: object) -> None:
        try:
            raise cause
        except cause:
            raise typer.Abort from None

    monkeypatch.setattr(shot_module, "connected", asked)
    assert cli.run(["shot", "--pressure-kpa", "40", "--offset-mm", "6"]) == code
    assert "a question that was not answered" in capsys.readouterr().err


def test_a_fall_without_a_bounce_is_told_as_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    document = {
        "shot": "20260131-000001", "state": "analysed", "failure": None, "simulated": False,
        "settings": {"pressure_a_kpa": 0.0, "pressure_b_kpa": 0.0, "offset_mm": 0.0},
        "result": {"impacts": [], "positions": {"frame": list(range(30))}},
    }  # fmt: skip
    monkeypatch.setattr(shot_module, "connected", lambda *_: nullcontext())
    monkeypatch.setattr(shot_module, "fire_and_wait", lambda *_, **__: document)
    assert cli.run(["shot", "--pressure-kpa", "0", "--offset-mm", "0"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "no bounce: a flight in 30 frames" in shown
    assert "rigctl qualify drop" in shown


def test_an_error_without_bound_is_shown_as_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    document = {
        "shot": "20260131-000001", "state": "analysed", "failure": None, "simulated": False,
        "settings": {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0},
        "result": {"e": {"value": 0.73, "sigma": None, "unit": "1"}},
    }  # fmt: skip
    monkeypatch.setattr(shot_module, "connected", lambda *_: nullcontext())
    monkeypatch.setattr(shot_module, "fire_and_wait", lambda *_, **__: document)
    assert cli.run(["shot", "--pressure-kpa", "40", "--offset-mm", "6"]) == 0
    assert "0.73 inf" in " ".join(capsys.readouterr().out.split())


def test_without_a_daemon_the_command_says_how_to_start_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("RIGCTL_KEY", raising=False)
    assert cli.run(["shot", "--pressure-kpa", "40", "--offset-mm", "6"]) == 2
    assert "rigctl serve" in capsys.readouterr().err


ROUNDED = [
    ((-3.11237, 0.00213), ("-3.1124", "0.0021")),
    ((0.73942, 0.0131), ("0.739", "0.013")),
    ((412.3, 25.0), ("412", "25")),
    ((1.0, 0.0), ("1", "0")),
    ((1.5, float("inf")), ("1.5", "inf")),
]


@pytest.mark.parametrize(("given", "text"), ROUNDED)
def test_numbers_are_shown_to_the_second_digit_of_their_error(
    given: tuple[float, float], text: tuple[str, str]
) -> None:
    assert rounded(*given) == text


def client(answerer: Any) -> ServiceClient:
    return ServiceClient(ServiceAddress("http://rig", "k"), httpx.MockTransport(answerer))


ERRORS = [
    RefusedError("the rig is firing", todo="wait"),
    SettingsError("too high", part="pressure_a_kpa", value="400 kPa", limit="5 to 120 kPa"),
    KeyRunningError("still under way", shot="20260131-000001"),
    NotFoundError("no such shot"),
    IdempotencyError("the key is empty"),
]


@pytest.mark.parametrize("error", ERRORS)
def test_a_problem_document_comes_back_as_the_error_it_was_made_from(error: RigError) -> None:
    def answerer(_: httpx.Request) -> httpx.Response:
        made = answer(from_error(error))
        return httpx.Response(made.status_code, content=made.body, headers=dict(made.headers))

    with client(answerer) as service, pytest.raises(type(error)) as raised:
        service.arm(SETTINGS)
    assert type(raised.value) is type(error)
    assert str(raised.value) == str(error)


@pytest.mark.parametrize(("status", "kind"), [(500, RigError), (409, RefusedError)])
def test_an_answer_that_is_no_problem_document_is_told_by_its_status(
    status: int, kind: type[RigError]
) -> None:
    service = client(lambda _: httpx.Response(status, text="<html>"))
    with service, pytest.raises(kind, match=str(status)):
        service.shot("x")


def test_a_lost_answer_to_a_fire_is_never_sent_again() -> None:
    calls = []

    def lose(request: httpx.Request) -> httpx.Response:
        calls.append(request)
        raise httpx.ReadTimeout("lost", request=request)

    with client(lose) as service, pytest.raises(RigError, match="before anything is fired again"):
        service.fire("token", "key", None)
    assert len(calls) == 1


def test_a_daemon_that_is_gone_is_told_from_one_that_fell_silent() -> None:
    def refuse(request: httpx.Request) -> httpx.Response:
        raise httpx.ConnectError("refused", request=request)

    with client(refuse) as service, pytest.raises(ConfigurationError, match="rigctl serve"):
        service.arm(SETTINGS)
