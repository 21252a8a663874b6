"""A telephone films a shot: somebody says that it records, and brings its film, by command."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.invoked import rigctl
from tests.plain_http import REQUESTS, lives
from tests.system.real_rig import KEY, RIGCTL, WAIT_S, until
from tests.telephones import RESTITUTION, configure, film

SHOT = ("shot", "--pressure-kpa", "0", "--offset-mm", "0")


@dataclass
class Rig:
    folder: Path
    url: str

    def start(self, *words: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [*RIGCTL, *words, "--config", "rig.toml", "--json"],
            cwd=self.folder,
            env={**os.environ, "RIGCTL_KEY": KEY},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def command(self, *words: str) -> tuple[int, str, str]:
        done = rigctl(*words, "--config", "rig.toml", "--json", folder=self.folder, key=KEY)
        return done.returncode, done.stdout, done.stderr

    def waits_for(self) -> str:
        answer = REQUESTS.get(
            f"{self.url}/api/v1/rig/film",
            headers={"Authorization": f"Bearer {KEY}"},
            timeout=WAIT_S,
        )
        return str(answer.json()["waits_for"])


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    folder = tmp_path_factory.mktemp("telephone")
    configure(folder)
    film(folder / "drop.mp4")
    film(folder / "short.mp4", frames=100)
    written = folder / "data-plate" / "service.json"
    with (folder / "serve.log").open("w") as log:
        daemon = subprocess.Popen(
            [*RIGCTL, "serve", "--config", "rig.toml", "--port", "0"],
            cwd=folder,
            env={**os.environ, "RIGCTL_KEY": KEY},
            stdout=log,
            stderr=log,
        )
    try:
        until(lambda: daemon.poll() is not None or written.exists(), WAIT_S)
        assert daemon.poll() is None, (folder / "serve.log").read_text()
        opened = Rig(folder, str(json.loads(written.read_text())["url"]))
        until(lambda: lives(opened.url), WAIT_S)
        yield opened
    finally:
        daemon.terminate()
        daemon.wait(WAIT_S)


def test_nothing_is_taken_while_no_shot_waits(rig: Rig) -> None:
    assert rig.waits_for() == "nothing"
    for words in (("--records",), ("drop.mp4",), ("--gives-up",)):
        code, _, said = rig.command("film", *words)
        assert code == 3, said
        assert "no shot waits" in said


def test_a_shot_is_fired_at_a_persons_word_and_measured_from_the_film_that_is_brought(
    rig: Rig,
) -> None:
    shot = rig.start(*SHOT, "--wait-s", "300")
    until(lambda: shot.poll() is not None or rig.waits_for() == "recording", WAIT_S)
    assert shot.poll() is None, shot.communicate()
    code, _, said = rig.command("film", "drop.mp4")
    assert code == 3, said
    assert rig.command("film", "--records")[0] == 0
    until(lambda: rig.waits_for() == "film", WAIT_S)

    code, _, said = rig.command("film", "short.mp4")
    assert code == 2, said
    assert "100 frames" in said
    assert "225" in said
    assert rig.waits_for() == "film"

    code, said, wrong = rig.command("film", "drop.mp4")
    assert code == 0, wrong
    out, err = shot.communicate(timeout=5 * WAIT_S)
    assert shot.returncode == 0, err
    result = json.loads(out)["result"]
    first = result["impacts"][0]["e"]
    assert abs(first["value"] - RESTITUTION) < 4 * first["sigma"] + 0.002
    assert first["sigma"] < 0.02


def test_a_shot_without_a_film_is_given_up_and_the_next_one_waits_anew(rig: Rig) -> None:
    shot = rig.start(*SHOT)
    until(lambda: rig.waits_for() == "recording", WAIT_S)
    assert rig.command("film", "--gives-up")[0] == 0
    _, err = shot.communicate(timeout=WAIT_S)
    assert shot.returncode != 0
    assert "given up" in err
    shot = rig.start(*SHOT)
    until(lambda: rig.waits_for() == "recording", WAIT_S)
    assert rig.command("film", "--gives-up")[0] == 0
    shot.communicate(timeout=WAIT_S)
