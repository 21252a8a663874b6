"""`rigctl shot`: arm, fire once, wait for the measurement, print it."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, Protocol

from pydantic import TypeAdapter, ValidationError

from rigctl.commands import report
from rigctl.errors import NotFoundError, RefusedError, SettingsError
from rigctl.service.models import CampaignName
from rigctl.settings import ShotSettings

_ON_THE_WAY = frozenset({"accepted", "firing", "capturing", "stored", "analysing"})
_WITHOUT_FRAMES = frozenset({"misfire", "aborted", "unknown_outcome", "interrupted"})
_POLL_S = 0.1
_CAMPAIGN: TypeAdapter[str | None] = TypeAdapter(CampaignName | None)


@dataclass(frozen=True, slots=True)
class Order:
    """One shot as the command line asks for it; `wait_s` bounds the wait for its measurement.

    Raises
    ------
    SettingsError
        The campaign's name could not be a folder's: found before any rig is armed.
    """

    settings: ShotSettings
    campaign: str | None
    wait_s: float

    def __post_init__(self) -> None:
        """Refuse a name that the service would refuse."""
        try:
            _CAMPAIGN.validate_python(self.campaign)
        except ValidationError as error:
            raise SettingsError(
                "is not a campaign's name",
                part="campaign",
                value=repr(self.campaign),
                limit="1 to 64 letters, digits, dots, hyphens or underscores, first a letter or "
                "digit",
                todo="choose another name",
            ) from error


class Operable(Protocol):
    """A rig to fire a shot with: behind a running daemon, or inside this process."""

    def arm(self, settings: ShotSettings) -> str:
        """Set the rig and return the arm token."""

    def fire(self, token: str, key: str, campaign: str | None) -> str:
        """Fire once under this idempotency key and return the shot's id."""

    def shot(self, shot: str) -> Mapping[str, Any]:
        """Return the shot as REST shows it."""

    def result(self, shot: str) -> Mapping[str, Any]:
        """Return the shot's measurement; raise `NotFoundError` while there is none."""


def settings_of(**fields: float | None) -> ShotSettings:
    """Return checked settings; a field that is None is left out.

    Raises
    ------
    SettingsError
        A value is not a finite number within the bounds of physics.
    """
    given = {name: value for name, value in fields.items() if value is not None}
    try:
        return ShotSettings.model_validate(given)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        name = str(first["loc"][0])
        raise SettingsError(
            first["msg"][0].lower() + first["msg"][1:],
            part=name,
            value=str(first["input"]),
            todo="choose another value",
        ) from error


def shot(order: Order, opened: AbstractContextManager[Operable], *, as_json: bool) -> None:
    """Fire one shot and print what was measured.

    Raises
    ------
    RefusedError
        The rig refused, or the shot did not come through.
    NotFoundError
        The shot was fired, and there is no measurement of it.
    """
    with opened as rig, report.progress() as say:
        document = fire_and_wait(rig, order, say)
    report.show_shot(document, as_json=as_json)
    _require_measured(document)


def fire_and_wait(
    rig: Operable,
    order: Order,
    say: Callable[[str], None],
    *,
    clock: Callable[[], float] = time.monotonic,
    pause: Callable[[float], None] = time.sleep,
) -> dict[str, Any]:
    """Fire one shot and return it as REST shows it, with its measurement under `result`.

    The measurement is waited for at most `order.wait_s`; `result` is None when there is none.
    """
    say("setting pressure and offset")
    token = rig.arm(order.settings)
    say("firing")
    name = rig.fire(token, str(uuid.uuid4()), order.campaign)
    say(f"shot {name}: waiting for its measurement")
    return measured(rig, name, order.wait_s, clock=clock, pause=pause)


def measured(
    rig: Operable,
    name: str,
    wait_s: float,
    *,
    clock: Callable[[], float] = time.monotonic,
    pause: Callable[[float], None] = time.sleep,
) -> dict[str, Any]:
    """Wait for the measurement of a fired shot, as `fire_and_wait`, and return the same."""
    deadline = clock() + wait_s
    record = rig.shot(name)
    while record["state"] in _ON_THE_WAY and clock() < deadline:
        pause(_POLL_S)
        record = rig.shot(name)
    ended = record["state"] in {"analysed", "refused"}
    return {**record, "result": rig.result(name) if ended else None}


def _require_measured(document: Mapping[str, Any]) -> None:
    state, name = str(document["state"]), str(document["shot"])
    why = f": {document['failure']}" if document["failure"] else ""
    if state in _WITHOUT_FRAMES:
        raise RefusedError(
            f"the shot ended as {state.replace('_', ' ')}{why}",
            shot=name,
            todo="look at the rig before the next one",
        )
    if state == "refused":
        raise NotFoundError(
            f"the frames are stored, but the analysis refused them{why}",
            shot=name,
            todo="look at the frames",
        )
    if state in _ON_THE_WAY:
        raise NotFoundError(
            f"the shot is {state}, its measurement did not come in time",
            shot=name,
            todo=f"ask later with GET /api/v1/shots/{name}/result",
        )
