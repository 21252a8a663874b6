"""What was seen counts for what it was seen of: this wiring, this configuration, a real rig."""

from __future__ import annotations

import dataclasses
import json
import sqlite3
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rigctl.commissioning.answers import YES, Answer, Answers, marks_of
from rigctl.commissioning.gate import Gate
from rigctl.commissioning.steps import steps_of
from rigctl.config import Configuration, load
from rigctl.store import Store

CONFIG = Path(__file__).parents[3] / "config"
BOX = {"trigger": "RIGTRIG 2 2"}


def answers(configuration: Configuration, firmware: dict[str, str] | None = None) -> Any:
    """A yes to every step of a configuration, as the store holds them."""
    said = BOX if firmware is None else firmware
    entries = tuple(
        Answer(
            about=step.name,
            answer=YES,
            at="2026-05-04T10:00:00+00:00",
            people=("Anna Berg",),
            actor="anna",
            found="",
            note="",
            configuration=configuration.digest,
            firmware=said,
            marks=marks_of(step, configuration, said),
        )
        for step in steps_of(configuration)
    )
    return SimpleNamespace(entries=entries)


def changed(configuration: Configuration, path: str, value: object) -> Configuration:
    """The configuration with another value at a dotted path."""
    document = configuration.model_dump(mode="json")
    *sections, name = path.split(".")
    section = document
    for each in sections:
        section = section[each]
    assert section[name] != value
    section[name] = value
    return Configuration.model_validate_json(json.dumps(document))


def asked(configuration: Configuration, seen: Any, firmware: dict[str, str] | None = None) -> Any:
    gate = Gate(configuration, seen, lambda: BOX if firmware is None else firmware)
    return {each.step.part.value: each.missing for each in gate.missing()}


@pytest.fixture
def pusher() -> Configuration:
    return load(CONFIG / "pusher.toml")


def test_nothing_is_asked_for_when_every_step_was_seen(pusher: Configuration) -> None:
    assert asked(pusher, answers(pusher)) == {}


@pytest.mark.parametrize(
    ("path", "value", "parts"),
    [
        ("trigger.pulse_us", 10_000, {"trigger"}),
        ("trigger.port", "/dev/ttyUSB7", {"trigger"}),
        ("regulator.unit_a", "C", {"regulator", "stop"}),
        ("slide.microsteps_per_mm", 2000.0, {"slide", "stop"}),
        ("cut_off.channel", 2, {"cut-off", "stop"}),
        ("camera.frame_rate_hz", 500.0, {"camera"}),
        ("camera.device", "/dev/video3", {"camera"}),
        ("limits.pressure_kpa", [5.0, 60.0], {"regulator", "interlocks"}),
        ("limits.cool_down_s", 20.0, {"interlocks"}),
        ("service.port", 8490, {"stop"}),
        ("environment.gravity_m_per_s2", 9.81, set()),
        ("analysis.workers", 2, set()),
    ],
)
def test_a_change_asks_for_the_steps_of_the_parts_that_it_touches_and_no_others(
    pusher: Configuration, path: str, value: object, parts: set[str]
) -> None:
    found = asked(changed(pusher, path, value), answers(pusher))
    assert set(found) == parts
    for missing in found.values():
        assert missing.startswith("changed since 2026-05-04: ")


def test_another_firmware_asks_for_the_triggers_steps_by_that_name(pusher: Configuration) -> None:
    found = asked(pusher, answers(pusher), {"trigger": "RIGTRIG 2 9"})
    assert set(found) == {"trigger"}
    assert found["trigger"] == "changed since 2026-05-04: firmware of the trigger"


def test_what_was_seen_in_a_rehearsal_counts_for_nothing_on_the_real_rig() -> None:
    rehearsed = load(CONFIG / "simulated.toml")
    real = rehearsed.model_copy(update={"simulation": None})
    seen = answers(rehearsed)
    gate = Gate(real, seen, lambda: BOX)
    missing = gate.missing()
    assert [each.step.name for each in missing] == [step.name for step in steps_of(real)]
    assert all("simulation" in each.missing for each in missing)
    # The rehearsal itself is complete, and a simulated rig needs none anyway.
    assert asked(rehearsed, seen) == {}


def test_a_step_that_was_said_no_to_since_is_asked_for_with_what_was_seen(
    pusher: Configuration,
) -> None:
    seen = answers(pusher)
    first = seen.entries[0]
    said = dataclasses.replace(first, answer="no", note="the lamp stays on")
    seen.entries += (said,)
    gate = Gate(pusher, seen, lambda: BOX)
    (missing,) = gate.missing()
    assert (missing.step.name, "the lamp stays on" in missing.missing) == (first.about, True)


def test_an_answer_whose_text_was_changed_in_the_catalogue_counts_for_nothing(
    store: Store, pusher: Configuration
) -> None:
    kept = Answers(store)
    said = answers(pusher).entries[:2]
    for each in said:
        kept.add(each)
    assert Answers(store).entries == said
    with sqlite3.connect(store.path / "catalogue.db") as catalogue:
        guards = "SELECT name FROM sqlite_master WHERE type = 'trigger' AND tbl_name = 'edits'"
        for (name,) in catalogue.execute(guards).fetchall():
            catalogue.execute(f"DROP TRIGGER {name}")
        forged = "UPDATE edits SET after = replace(after, 'Anna Berg', 'Eve') WHERE subject = ?"
        catalogue.execute(forged, (said[0].about,))
    catalogue.close()
    assert Answers(store).entries == said[1:]
