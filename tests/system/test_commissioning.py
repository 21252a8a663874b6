"""A real rig is walked through before it fires: over REST and by command, with hands at it."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from typing import Any

import pytest

from tests.invoked import rigctl
from tests.system.real_rig import RealRig, real_rig, until

SETTINGS = {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0, "offset_mm": 6.0}
ANNA = ["Anna Berg", "Bo Lind"]
WALK = "/rig/commissioning"

HANDS: dict[str, tuple[str, str]] = {
    "cut-off-unplugged": ("cut-off", "unplug"),
    "cut-off-back": ("cut-off", "plug-in"),
    "trigger-unplugged": ("trigger", "unplug"),
    "trigger-plugged-in": ("trigger", "plug-in"),
    "regulator-unplugged": ("regulator", "unplug"),
    "regulator-plugged-in": ("regulator", "plug-in"),
    "slide-unplugged": ("slide", "unplug"),
    "slide-plugged-in": ("slide", "plug-in"),
    "camera-unplugged": ("recorder", "unplug"),
    "camera-plugged-in": ("recorder", "plug-in"),
}
"""What a person does at the rig for a step, as a fault of the simulated laboratory."""


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RealRig]:
    """A rig of which little was seen."""
    with real_rig(tmp_path_factory.mktemp("fresh")) as opened:
        opened.start()
        yield opened


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RealRig]:
    """A rig of which everything was seen; each test leaves it so."""
    with real_rig(tmp_path_factory.mktemp("seen")) as opened:
        opened.start()
        see_all(opened)
        yield opened


def steps(rig: RealRig) -> list[dict[str, Any]]:
    return list(rig.ask("GET", WALK).json()["steps"])


def missing(rig: RealRig) -> list[str]:
    return [step["name"] for step in steps(rig) if step["missing"]]


def hands(rig: RealRig, name: str) -> None:
    """Do what a person does at the rig for a step."""
    rig.hand(switch=name != "own-switch")
    rig.set_clock(60.0 if name == "clock" else 0.0)
    if name in HANDS:
        rig.fault(*HANDS[name])


def see(rig: RealRig, name: str, act: str | None) -> None:
    """Do one step with the hands it needs, and answer yes."""
    hands(rig, name)
    if act is not None:
        found = rig.ask("POST", f"{WALK}/{name}/act")
        assert found.status_code == 200, found.text
        assert found.json()["holds"], (name, found.text)
    answer = rig.ask("POST", f"{WALK}/{name}/answer", {"seen": True, "people": ANNA})
    assert (answer.status_code, answer.json()["missing"]) == (200, ""), answer.text


def see_all(rig: RealRig) -> None:
    for step in steps(rig):
        if step["missing"]:
            see(rig, step["name"], step["act"])


def arm(rig: RealRig) -> Any:
    return rig.ask("POST", "/rig/arm", SETTINGS)


def require_refused(rig: RealRig, step: str) -> None:
    """The refusal names the step and the command, and nothing has moved by it."""
    before = rig.state()
    refused = arm(rig)
    assert refused.status_code == 409
    document = refused.json()
    assert "interlocks" in document, document
    (sentence,) = document["interlocks"]
    assert sentence.startswith("commissioning:")
    assert f"'{step}'" in sentence
    assert "`rigctl commission`" in document["detail"]
    after = rig.state()
    assert {key: after[key] for key in ("fires", "offset_mm", "armed")} == {
        key: before[key] for key in ("fires", "offset_mm", "armed")
    }


def test_a_real_rig_fires_nothing_and_names_step_and_command(fresh: RealRig) -> None:
    first = missing(fresh)[0]
    require_refused(fresh, first)
    fired = fresh.command("shot", "--pressure-kpa", "40", "--offset-mm", "6")
    assert fired.returncode == 3
    assert f"'{first}'" in fired.stderr
    assert "rigctl commission" in fired.stderr
    assert fresh.state()["fires"] == 0
    assert "rigctl commission" in " ".join(fresh.ask("GET", "/rig").json()["warnings"])


@pytest.mark.long
@pytest.mark.parametrize(
    ("store", "said"),
    [("data", "another process owns the store"), ("other-store", "is held by another program")],
)
def test_a_second_daemon_on_the_same_rig_is_refused_by_name_and_moves_nothing(
    fresh: RealRig, store: str, said: str
) -> None:
    text = (fresh.folder / "rig.toml").read_text()
    assert str(fresh.folder / "data") in text
    second = text.replace(str(fresh.folder / "data"), str(fresh.folder / store))
    (fresh.folder / "second.toml").write_text(second)
    before = fresh.state()
    refused = fresh.second_daemon("second.toml")
    assert refused.returncode == 3
    assert said in refused.stderr
    assert fresh.state() == before
    assert fresh.ask("GET", "/rig").json()["state"] == "idle"


def test_nothing_moves_for_a_step_before_the_cut_off_was_seen(fresh: RealRig) -> None:
    refused = fresh.ask("POST", f"{WALK}/pulses/act")
    assert refused.status_code == 409
    assert "cut-off" in refused.json()["detail"]
    assert fresh.state()["fires"] == 0


def test_a_yes_to_what_was_not_done_is_refused(fresh: RealRig) -> None:
    refused = fresh.ask("POST", f"{WALK}/pulses/answer", {"seen": True, "people": ANNA})
    assert refused.status_code == 409
    nobody = fresh.ask("POST", f"{WALK}/pulses/answer", {"seen": True, "people": []})
    assert nobody.status_code == 422
    assert "pulses" in missing(fresh)


def test_a_step_that_is_left_stays_asked_for_and_the_walk_goes_on(fresh: RealRig) -> None:
    walked = fresh.command("commission", "--person", "Anna Berg", typed="\nl\n")
    assert "2 of" in walked.stdout
    assert missing(fresh)[0] == "supply"


def test_the_walk_by_command_stops_at_a_no_and_goes_on_there(fresh: RealRig) -> None:
    typed = "\ny\n" + "\nn\nthe lamp stays on\n"
    assert missing(fresh)[0] == "supply"
    walked = fresh.command("commission", "--person", "Anna Berg", typed=typed)
    assert walked.returncode == 3, walked.stdout + walked.stderr
    assert "the lamp stays on" in walked.stderr
    assert missing(fresh)[0] == "stop"
    stopped = next(step for step in steps(fresh) if step["name"] == "stop")
    assert (stopped["answer"], stopped["people"]) == ("no", ["Anna Berg"])
    assert "the lamp stays on" in stopped["missing"]


def test_when_every_step_was_seen_the_rig_fires(seen: RealRig) -> None:
    assert missing(seen) == []
    before = seen.state()["fires"]
    fired = seen.command("shot", "--pressure-kpa", "40", "--offset-mm", "6", "--wait-s", "0")
    until(lambda: seen.state()["fires"] == before + 1)
    assert "commission" not in fired.stderr


def test_what_was_seen_outlasts_a_restart_and_stands_in_a_signed_record(seen: RealRig) -> None:
    seen.end()
    seen.start()
    assert missing(seen) == []
    written = seen.command("commission", "--record", "record.json")
    assert (written.returncode, "may fire" in written.stdout) == (0, True), written.stderr
    path = seen.folder / "record.json"
    record = json.loads(path.read_text())
    assert record["complete"]
    assert set(ANNA) <= set(record["people"])
    assert record["firmware"] == {"trigger": "RIGTRIG 2 2"}
    assert seen.command("commission", "--verify", "record.json").returncode == 0
    elsewhere = rigctl("commission", "--verify", path, folder=seen.folder / "laboratory")
    assert elsewhere.returncode == 3
    assert "name with --config" in elsewhere.stderr
    record["people"] = ["Somebody Else"]
    path.write_text(json.dumps(record))
    forged = seen.command("commission", "--verify", "record.json")
    assert forged.returncode == 3
    assert "does not fit" in forged.stderr
    checked = seen.command("verify")
    assert checked.returncode == 0, checked.stdout + checked.stderr


@pytest.mark.long
def test_a_changed_configuration_asks_for_what_it_changes_alone(seen: RealRig) -> None:
    seen.end()
    seen.edit("microsteps_per_mm = 2015.75", "microsteps_per_mm = 2015.7")
    seen.start()
    assert missing(seen) == ["offset", "slide-unplugged", "slide-plugged-in", "stop-in-motion"]
    assert "slide" in next(step["missing"] for step in steps(seen) if step["missing"])
    require_refused(seen, "offset")
    seen.end()
    seen.edit("microsteps_per_mm = 2015.7", "microsteps_per_mm = 2015.75")
    seen.start()
    assert missing(seen) == []


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["lamp", "--note", "new"], 4, "lamp: is no part of this rig (limit cut-off, trigger"),
        (["trigger"], 2, "note: is empty; say with --note what was done"),
    ],
)
def test_what_cannot_have_been_rewired_is_refused_before_anybody_is_asked_for_a_name(
    seen: RealRig, words: list[str], status: int, said: str
) -> None:
    told = seen.command("commission", "--rewired", *words, typed="")
    assert (told.returncode, "Who looks" in told.stdout) == (status, False)
    assert said in told.stderr
    assert missing(seen) == []


def test_a_rewired_part_is_asked_for_again_and_seen_by_command(seen: RealRig) -> None:
    told = seen.command("commission", "--rewired", "stop", "--note", "new relay", "--person", "Bo")
    assert told.returncode == 0, told.stderr
    assert missing(seen) == ["stop-in-motion", "stop-by-hand", "released"]
    require_refused(seen, "stop-in-motion")
    walked = seen.command("commission", "--person", "Bo", typed="\ny\n" + "y\n" + "\ny\n")
    assert walked.returncode == 0, walked.stdout + walked.stderr
    assert "the rig may fire" in walked.stdout
    assert arm(seen).status_code == 200


@pytest.mark.long
def test_an_answer_that_the_store_did_not_seal_counts_for_nothing(seen: RealRig) -> None:
    seen.end()
    catalogue = sqlite3.connect(seen.folder / "data" / "catalogue.db")
    with catalogue:
        guards = "SELECT name FROM sqlite_master WHERE type = 'trigger' AND tbl_name = 'edits'"
        for (name,) in catalogue.execute(guards).fetchall():
            catalogue.execute(f"DROP TRIGGER {name}")
        catalogue.execute(
            "UPDATE edits SET after = replace(after, 'Anna Berg', 'Eve') "
            "WHERE subject = 'own-switch'"
        )
    catalogue.close()
    seen.start()
    assert missing(seen) == ["own-switch"]
    require_refused(seen, "own-switch")
    see_all(seen)
