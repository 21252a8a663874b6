"""`rigctl sweep`: from options to a form, and from the daemon's answers to words and exit codes."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from rigctl.cli import run
from rigctl.cli.rig import sweep as commands
from rigctl.errors import RefusedError
from rigctl.store import StepState

ONE, TWO = "20260131-s0001", "20260131-s0002"


def view(name: str, state: str, stored: int, **changes: Any) -> dict[str, Any]:
    counts = {str(each): 0 for each in StepState} | {"stored": stored, "waiting": 4 - stored}
    found = {"sweep": name, "state": state, "reason": "so it is", "asked": None, "steps": 4}
    return {**found, "counts": counts, "left_s": None, "mean": None, "warnings": [], **changes}


class Daemon:
    """Stands in for the client of a running daemon; each look at a sweep finds it further on."""

    def __init__(self, last: dict[str, Any]) -> None:
        self.last = last
        self.looks = [view(ONE, "running", 1, left_s=95.0), view(ONE, "running", 3, left_s=5.0)]
        self.started: list[tuple[dict[str, Any], str]] = []
        self.orders: list[tuple[str, str]] = []
        self.listed = [view(TWO, "completed", 4), view(ONE, "paused", 2)]

    def start_sweep(self, form: dict[str, Any], key: str) -> dict[str, Any]:
        self.started.append((form, key))
        return self.last

    def sweeps(self) -> dict[str, Any]:
        return {"sweeps": self.listed, "next": None}

    def sweep(self, name: str) -> dict[str, Any]:
        return {**(self.looks.pop(0) if self.looks else self.last), "sweep": name}

    def sweep_steps(self, _: str) -> dict[str, Any]:
        failed = {"step": 2, "shot": "20260131-000002", "failure": "no frames came"}
        return {"form": {}, "table": [failed]}

    def order_sweep(self, name: str, wish: str) -> dict[str, Any]:
        self.orders.append((name, wish))
        return self.last


@pytest.fixture
def daemon(monkeypatch: pytest.MonkeyPatch) -> Daemon:
    stand_in = Daemon(view(ONE, "completed", 4))

    @contextmanager
    def service(_: Path | None, __: str | None) -> Iterator[Daemon]:
        yield stand_in

    monkeypatch.setattr(commands, "connected", service)
    monkeypatch.setattr(commands, "_POLL_S", 0.0)
    return stand_in


RANGES = ["--pressure-kpa", "20:80:7", "--offset-mm", "0,6,12"]


def test_ranges_become_a_grid_under_a_fresh_key(daemon: Daemon, capsys: Any) -> None:
    options = ["--repeat", "2", "--seed", "7", "--campaign", "nylon", "--until", "e=0.001"]
    assert run(["sweep", *RANGES, *options, "--adaptive"]) == 0
    assert run(["sweep", *RANGES, "--no-shuffle"]) == 0
    (form, key), (plain, other) = daemon.started
    assert form == {
        "campaign": "nylon",
        "repeat": 2,
        "seed": 7,
        "until": {"coefficient": "e", "sigma": 0.001, "adaptive": True},
        "grid": {
            "pressure_a_kpa": {"first": 20.0, "last": 80.0, "count": 7},
            "offset_mm": [0.0, 6.0, 12.0],
        },
    }
    assert plain["shuffle"] is False
    assert key != other
    assert "4 of 4 steps: 4 stored" in capsys.readouterr().out


def test_a_file_is_read_and_watched_to_its_end(daemon: Daemon, tmp_path: Path, capsys: Any) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text("[grid]\npressure_a_kpa = [40.0]\noffset_mm = [1.0, 2.0]\n")
    assert run(["sweep", str(file), "--json"]) == 0
    assert daemon.looks == []
    document = json.loads(capsys.readouterr().out)
    assert (document["state"], document["table"][0]["step"]) == ("completed", 2)


@pytest.mark.parametrize(
    ("config", "said"),
    [(None, "pressure_a_kpa.*-5 kPa.*5 to 120 kPa.*choose"), ("none.toml", "pressure_a_kpa.*-5")],
)
def test_a_listed_shot_beyond_any_rig_is_refused_by_its_value(
    config: str | None, said: str, tmp_path: Path, capsys: Any
) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text("[[shots]]\npressure_a_kpa = -5.0\npressure_b_kpa = 40.0\noffset_mm = 1.0\n")
    named = [] if config is None else ["--config", str(tmp_path / config)]
    assert run(["sweep", str(file), *named]) == 2
    assert re.search(said, " ".join(capsys.readouterr().err.split()))


def test_a_sweep_that_waits_for_a_person_ends_with_3_and_its_reason(
    daemon: Daemon, capsys: Any
) -> None:
    daemon.last = view(ONE, "paused", 2, reason="pressure_a: 43 kPa")
    assert run(["sweep", *RANGES]) == 3
    said = capsys.readouterr()
    assert "the sweep is paused: pressure_a: 43 kPa" in said.err
    assert "step 2 (shot 20260131-000002): no frames came" in said.out


def test_a_detached_sweep_is_left_to_the_daemon(daemon: Daemon, capsys: Any) -> None:
    assert run(["sweep", *RANGES, "--detach"]) == 0
    assert len(daemon.looks) == 1
    assert "about 1 min 35 s left" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "Usage"),
        (["--offset-mm", "1:2:3"], "--pressure-kpa and --offset-mm"),
        (["--pressure-kpa", "20:80", "--offset-mm", "1"], "--pressure-kpa.*20:80.*A:B:N"),
        (["--pressure-kpa", "20:80:x", "--offset-mm", "1"], "--pressure-kpa"),
        (["--pressure-kpa", "20:80:0", "--offset-mm", "1"], "grid.pressure_a_kpa.*count"),
        (["--pressure-kpa", "40:40:3", "--offset-mm", "1"], "empty"),
        (["--pressure-kpa", "40,40", "--offset-mm", "1"], "40 stands twice"),
        (["--pressure-kpa", "nan", "--offset-mm", "1"], "finite"),
        (["--pressure-kpa", "40", "--offset-mm", "500"], "offset_mm.*500 mm.*0 to 24 mm.*choose"),
        (
            ["--pressure-kpa=-5:40:2", "--offset-mm", "1"],
            "pressure_a_kpa.*-5 kPa.*5 to 120 kPa.*choose",
        ),
        (["--pressure-kpa", "40,2000", "--offset-mm", "1"], "2000 kPa, allowed 5 to 120 kPa"),
        ([*RANGES, "--until", "e"], "NAME=SIGMA"),
        ([*RANGES, "--until", "mu=0.1"], "until.coefficient"),
        ([*RANGES, "--adaptive"], "--until"),
        ([*RANGES, "no.toml"], "not by both"),
        (["no.toml"], "no such file"),
    ],
)
def test_what_cannot_be_a_sweep_ends_with_2_and_one_sentence(
    daemon: Daemon, capsys: Any, arguments: list[str], words: str
) -> None:
    assert run(["sweep", *arguments]) == 2
    assert daemon.started == []
    said = capsys.readouterr()
    assert said.out == ""
    assert re.search(words, said.err), said.err


def test_orders_go_to_the_latest_sweep_that_has_not_ended(daemon: Daemon) -> None:
    for wish in ("pause", "resume", "abort"):
        assert run(["sweep", wish]) == 0
    assert run(["sweep", "abort", TWO]) == 0
    assert daemon.orders == [(ONE, "pause"), (ONE, "resume"), (ONE, "abort"), (TWO, "abort")]


def test_a_pause_waits_for_the_shot_under_way(daemon: Daemon, capsys: Any) -> None:
    daemon.last = view(ONE, "running", 1, asked="pause")
    daemon.looks = [daemon.last, daemon.last, view(ONE, "paused", 2), view(ONE, "paused", 2)]
    assert run(["sweep", "pause"]) == 0
    assert daemon.looks == []
    assert f"sweep {ONE}: paused; so it is" in capsys.readouterr().out


def test_the_status_is_that_of_the_latest_sweep(daemon: Daemon, capsys: Any) -> None:
    daemon.looks = []
    mean = {"coefficient": "e", "value": 0.74, "sigma": 0.0012, "shots": 9}
    daemon.last = view(ONE, "running", 2, mean=mean, asked="pause")
    assert run(["sweep", "status"]) == 0
    said = capsys.readouterr().out
    assert f"sweep {TWO}: running (pause asked)" in said
    assert "e = 0.74000 ± 0.0012, 9 shots" in said


def test_without_any_sweep_the_answer_is_not_found(daemon: Daemon, capsys: Any) -> None:
    daemon.listed = []
    assert run(["sweep", "status"]) == 4
    assert "there is no such sweep" in capsys.readouterr().err


def test_who_stops_watching_leaves_the_sweep_running(daemon: Daemon, capsys: Any) -> None:
    def interrupt(_: str) -> dict[str, Any]:
        raise KeyboardInterrupt

    daemon.sweep = interrupt  # type: ignore[method-assign]
    assert run(["sweep", *RANGES]) == 3
    assert "it goes on; rigctl sweep pause" in capsys.readouterr().err


def test_a_refusal_of_the_daemon_ends_with_3(daemon: Daemon, capsys: Any) -> None:
    def refuse(*_: object) -> dict[str, Any]:
        raise RefusedError("a sweep runs", todo="pause or abort it")

    daemon.start_sweep = refuse  # type: ignore[method-assign]
    assert run(["sweep", *RANGES]) == 3
    assert "a sweep runs" in capsys.readouterr().err
