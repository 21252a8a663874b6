"""One shot as pages show it: what became of it, its film and its coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from nicegui import run, ui

from rigctl.errors import RigError
from rigctl.page.desk import Desk
from rigctl.page.parts.quantities import COEFFICIENTS, VALUE
from rigctl.page.parts.tables import Cell, facts, measured
from rigctl.page.shots.analysing import Analysing
from rigctl.page.shots.player import Player
from rigctl.page.shots.refused import refused_card
from rigctl.store import ShotRecord, ShotState

Json = Mapping[str, Any]
WAITED_FOR = {
    ShotState.ACCEPTED: "accepted; the rig is about to fire",
    ShotState.FIRING: "firing",
    ShotState.CAPTURING: "the frames come in",
    ShotState.STORED: "the frames are on disk; its analysis waits",
    ShotState.ANALYSING: "its frames are being analysed",
}


async def read(desk: Desk, shot: ShotRecord) -> None:
    """Have a shot's folder read by a thread, so that drawing it afterwards waits for no disk."""
    await run.io_bound(_read, desk, shot)


def _read(desk: Desk, shot: ShotRecord) -> None:
    with suppress(RigError):
        desk.films.result(shot)
        if shot.frames:
            desk.films.film(shot)


def film(desk: Desk, shot: ShotRecord, *, start: int | None = None, keys: bool = False) -> None:
    """Place the film of a shot, or say why there is none.

    It begins at frame `start`; without it where the shot was refused, or at the contact.
    """
    if not shot.frames:
        waiting = WAITED_FOR.get(shot.state, shot.failure or "no frames were stored")
        ui.label(f"No film: {waiting}.").classes("empty")
        return
    try:
        result, found = desk.films.result(shot), desk.films.film(shot)
    except RigError as error:
        ui.label(error.sentence()).classes("empty")
        return
    if start is None and found.overlays.contact_frame is None:
        start = result.get("frame", found.brightest)
    if found.blank:
        _told(
            "Nothing stands out in these frames.",
            "See whether the lens is covered, the lamp is lit and the tubes were loaded.",
            testid="blank",
        )
    Player(shot, found.size, found.overlays, found.times_s, start=start, keys=keys)


def coefficients(desk: Desk, shot: ShotRecord) -> None:
    """Place the table of coefficients, or say what is waited for or why there are none."""
    result = desk.films.result(shot)
    if result.get("status") == "measured":
        lines = [measured(COEFFICIENTS[name], result.get(name)) for name in COEFFICIENTS]
        headings: list[Cell | str] = [
            Cell("quantity", "Definitions: point at each."),
            Cell("value ± σ", VALUE),
            "",
        ]
        facts(headings, lines, "coefficients")
        if shot.failure:
            _told("The last analysis added nothing.", shot.failure)
    elif shot.state in WAITED_FOR:
        ui.label(f"{WAITED_FOR[shot.state]} …".capitalize()).classes("empty")
        if shot.state in {ShotState.STORED, ShotState.ANALYSING}:
            Analysing(desk, shot)
        if shot.failure:
            _told("It is held up.", shot.failure)
    elif why := refusal(shot, result):
        refused_card(desk, shot, result, why)
    else:
        ui.label(f"{shot.state} …".capitalize()).classes("empty")


def _told(lead: str, why: str, testid: str = "refusal") -> None:
    with ui.element("div").classes("verdict bad").props(f"data-testid={testid}"):
        ui.label(lead).classes("lead")
        ui.label(why)


def refusal(shot: ShotRecord, result: Json) -> str:
    """Say why a shot has no coefficients, with step and frame; empty if nothing refused it."""
    if result.get("status") == "refused":
        place = f", frame {result['frame']}" if "frame" in result else ""
        return f"Refused at the step “{result['step']}”{place}: {result['reason']}."
    return shot.failure or ""
