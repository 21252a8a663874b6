"""Which steps a rig has, against what its configuration says that it is made of."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rigctl.commissioning.step import Act, Part
from rigctl.commissioning.steps import steps_of
from rigctl.config import Configuration, load
from rigctl.rig.bounds import require_within

CONFIG = Path(__file__).parents[3] / "config"
BENCHES = {"simulated-disk", "simulated-stage"}
"""They fire nothing."""
RIGS = sorted({path.stem for path in CONFIG.glob("*.toml")} - BENCHES)


def rig(name: str) -> Configuration:
    return load(CONFIG / f"{name}.toml")


def names(configuration: Configuration) -> list[str]:
    return [step.name for step in steps_of(configuration)]


@pytest.mark.parametrize("name", RIGS)
def test_every_step_has_a_name_of_its_own_and_says_what_to_do_and_to_see(name: str) -> None:
    steps = steps_of(rig(name))
    assert len({step.name for step in steps}) == len(steps)
    assert all(step.do and step.see and step.sections for step in steps)


@pytest.mark.parametrize("name", RIGS)
def test_whatever_arms_stays_within_the_limits_and_moves_after_the_cut_off(name: str) -> None:
    configuration = rig(name)
    steps = steps_of(configuration)
    last_cut_off = max(n for n, step in enumerate(steps) if step.part is Part.CUT_OFF)
    for number, step in enumerate(steps):
        if step.settings is not None:
            require_within(step.settings, configuration.limits)
        if step.may_move:
            assert number > last_cut_off, step.name
        # What else needs a rig that arms is refused there, and changes nothing.
        assert step.may_move or step.settings is None or step.act is Act.REFUSED


def test_the_pusher_has_its_regulators_slide_dead_man_and_heartbeat() -> None:
    found = names(rig("pusher"))
    assert {"pressure", "offset", "dead-man", "heartbeat", "stop-in-motion"} <= set(found)
    assert "remote-trigger" not in found


def test_the_release_apparatus_has_no_watch_that_would_drop_its_spheres() -> None:
    configuration = rig("release")
    found = names(configuration)
    assert not {"pressure", "offset", "dead-man", "heartbeat"} & set(found)
    assert "drop" in next(iter(steps_of(configuration))).do


def test_a_telephone_has_no_cable_to_pull_and_nothing_fires_without_a_persons_word() -> None:
    document = rig("pusher").model_dump(mode="json")
    document["camera"] = {
        "kind": "film", "frame_rate_hz": 240.0, "rows": 720, "columns": 400,
        "start_timeout_s": 120.0, "collect_timeout_s": 600.0,
        "frames_before_mark": 5, "frames_after_mark": 240,
    }  # fmt: skip
    steps = {
        step.name: step
        for step in steps_of(Configuration.model_validate_json(json.dumps(document)))
        if step.part is Part.CAMERA
    }
    assert set(steps) == {"frames", "nobody-films"}
    assert "rigctl film --records" in steps["frames"].do
    assert steps["nobody-films"].act is Act.UNRECORDED


def test_every_kind_of_act_is_asked_for_by_some_rig() -> None:
    asked = {step.act for name in RIGS for step in steps_of(rig(name))}
    assert set(Act) <= asked
