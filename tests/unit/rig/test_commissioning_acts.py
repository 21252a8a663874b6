"""What the daemon itself sees of a watch: that the rig stopped by itself, and why."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from rigctl.commissioning.step import Act, Step
from rigctl.commissioning.steps import steps_of
from rigctl.commissioning.walk import Acts
from rigctl.config import load

CONFIG = Path(__file__).parents[3] / "config"


@dataclass
class Standing:
    """A rig of which only the latch matters."""

    latch_reason: str | None
    state: str = "estop"
    released: list[str] = field(default_factory=list)

    def status(self) -> Standing:
        return self

    def release(self, actor: str, reason: str) -> None:
        self.released.append(reason)
        self.latch_reason, self.state = None, "idle"


def step(rig: str, name: str) -> Step:
    return next(step for step in steps_of(load(CONFIG / f"{rig}.toml")) if step.name == name)


def performed(rig: Standing, name: str) -> tuple[bool, str]:
    stands: Any = rig
    clock: Any = None
    found = Acts(stands, clock).perform(step("pusher", name), "anna")
    return found.holds, found.text


def test_a_box_that_has_made_itself_safe_is_seen_and_the_rig_released() -> None:
    rig = Standing("dead man: the trigger box has made itself safe: no heartbeat reached it")
    holds, text = performed(rig, "heartbeat")
    assert holds
    assert "stopped by itself" in text
    assert rig.released == ["commissioning, step heartbeat"]


@pytest.mark.parametrize(
    ("reason", "state", "said"),
    [
        (None, "idle", "the rig is idle and has not stopped by itself"),
        ("anna: supply measured", "estop", "for another reason: anna: supply measured"),
    ],
)
def test_a_rig_that_did_not_stop_by_itself_is_no_yes_and_is_left_as_it_is(
    reason: str | None, state: str, said: str
) -> None:
    rig = Standing(reason, state)
    holds, text = performed(rig, "heartbeat")
    assert not holds
    assert said in text
    assert not rig.released


def test_the_dead_man_is_read_from_the_reason_of_the_stop() -> None:
    rig = Standing("dead man: the dead man cut the power, or was ended by somebody else")
    assert performed(rig, "dead-man")[0]


def test_a_rehearsal_on_simulated_ports_asks_for_a_word_and_claims_no_measurement() -> None:
    assert step("simulated", "heartbeat").act is None
    assert step("pusher", "heartbeat").act is Act.LATCHED
