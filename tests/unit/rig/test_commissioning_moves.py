"""On a real rig nothing moves for a step before the cut-off was seen, whichever steps are left."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rigctl.commissioning.gate import Gate
from rigctl.commissioning.steps import steps_of
from rigctl.commissioning.walk import Commissioning
from rigctl.config import load
from rigctl.errors import RefusedError
from tests.unit.rig.rig_fakes import Laboratory

PUSHER = load(Path(__file__).parents[3] / "config" / "pusher.toml")
MOVES = {"regulator.set_pressure", "slide.move_to"}


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Laboratory]:
    laboratory = Laboratory(tmp_path / "data", configuration=PUSHER)
    yield laboratory
    laboratory.close()


def never_walked(lab: Laboratory) -> Commissioning:
    nothing: Any = SimpleNamespace(entries=())
    gate = Gate(PUSHER, nothing, dict, lab.time.clock())
    return Commissioning(PUSHER, lab.rig, gate, nothing, lab.time.clock())


@pytest.mark.parametrize("step", [step.name for step in steps_of(PUSHER) if step.act is not None])
def test_no_step_moves_anything_before_the_cut_off_was_seen(lab: Laboratory, step: str) -> None:
    walk = never_walked(lab)
    with suppress(RefusedError):
        walk.act(step, "anna")
    assert not MOVES & set(lab.log)
    assert not lab.trigger.fired


def test_the_refusal_of_an_open_switch_is_seen_with_everything_left_as_it_is(
    lab: Laboratory,
) -> None:
    lab.trigger.has_power = False
    found = never_walked(lab).act("own-switch", "anna")
    assert found.holds
    assert "trigger: without power" in found.text
    assert not MOVES & set(lab.log)


def test_a_switch_that_was_left_closed_is_no_refusal_at_the_trigger(lab: Laboratory) -> None:
    assert not never_walked(lab).act("own-switch", "anna").holds
