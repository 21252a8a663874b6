"""`rigctl model` on a campaign by name, in the store of a configuration that lies elsewhere."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from rigctl.cli import run
from rigctl.config import default_path
from simulators.challenge import write_challenge

WORDS = (
    *("agreement", "explain", "fit", "launch", "propose", "rank"),
    # What goes over the poses in parts opens them on two ways: for a verdict, and for a fit.
    *("explain --stream", "fit --stream"),
)


@pytest.fixture(scope="module")
def configuration(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a configuration whose store holds one imported campaign of twelve shots.

    Nothing is hidden in it: an answer is soon found.
    """
    place = tmp_path_factory.mktemp("laboratory")
    text = default_path().read_text(encoding="utf-8")
    stated, count = re.subn(
        r'(\[store\]\nfolder = )"[^"]*"', rf'\1"{place / "data"}"', text, count=1
    )
    assert count == 1
    (place / "rig.toml").write_text(stated)
    write_challenge(place / "handed-over", {}, seed=5, shots=12)
    words = ["import", str(place / "handed-over"), "--name", "nylon"]
    assert run([*words, "--config", str(place / "rig.toml")]) == 0
    return place / "rig.toml"


@pytest.mark.parametrize("words", WORDS)
def test_a_campaign_is_found_by_name_from_any_folder(
    configuration: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    word, *options = words.split()
    asked = ["model", word, "nylon", *options, "--json"]
    assert run([*asked, "--config", str(configuration)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["campaign"], document["shots"]) == ("nylon", 12)
    assert run(asked) == 4, "the simulated rig has no store in this folder"
