"""One shot as pages show it: what became of it, its film and its coefficients."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from nicegui import run, ui

from rigctl.errors import RigError
from rigctl.jobs.duration import Wait
from rigctl.page.desk import Desk
from rigctl.page.parts.presence import every
from rigctl.page.parts.quantities import COEFFICIENTS, VALUE
from rigctl.page.parts.tables import Cell, facts, measured
from rigctl.page.parts.waiting import UNSAID_S, fill, said_of
from rigctl.page.parts.widgets import button
from rigctl.page.shots.films import Film
from rigctl.page.shots.player import Player
from rigctl.page.shots.refused import refused_card
from rigctl.store import ShotRecord, ShotState

LOOK_S = 0.25
USUAL_S = 4.0
"""Of a shot of some twenty frames on a small computer, its worker's start with it, s."""
AGAIN_SAID = ("e", "beta")
COMPILES = "Machine code is being compiled, once on this host: it takes some minutes"
MEASURES = "Measuring its frames"
CANCELS = "It is being cancelled"


SOON_S = 90.0
"""Of a time left: more is said in halves of a minute, less in tens of seconds."""


def left_words(left_s: float | None) -> str:
    """Return the time that compiling will take still, no finer than it is known."""
    if left_s is None:
        return ""
    if left_s >= SOON_S:
        return f", about {round(left_s / 30.0) / 2:g} min left"
    return f", about {max(10, 10 * math.ceil(left_s / 10.0))} s left"


class Analysing:
    """Placed where the coefficients will stand, seen once the analysis lasts longer than a second.

    Seconds count from when the daemon queued it, so that a page that is reloaded counts on.
    Cancelled, the shot keeps its frames, and the host the machine code that was compiled by then.
    """

    def __init__(self, desk: Desk, shot: ShotRecord) -> None:
        self._desk, self._shot = desk, shot
        self._drawn_s, self._cancels = time.monotonic(), False
        with ui.element("div").classes("waiting").props("data-testid=analysing") as self._all:
            with ui.element("div").classes("beside"):
                self._said = ui.label(MEASURES).classes("strong").props("role=status")
                ui.space()
                cancel = button("Cancel", self._on_cancel, testid="cancel-analysis")
                cancel.tooltip("ends this at once; the frames are kept and can be analysed again")
            self._share = ui.linear_progress(0.0, show_value=False, size="8px").props(
                'rounded aria-label="the analysis of this shot"'
            )
            self._left = ui.label().classes("note")
        self._all.set_visibility(False)
        every(LOOK_S, self._show)

    def _show(self) -> None:
        now = time.monotonic()
        awaited, compiling = self._desk.daemon.awaited(self._shot.id), self._desk.daemon.compiling()
        gone = now - self._drawn_s if awaited is None else awaited.gone_s
        cancels = self._cancels or (awaited is not None and awaited.is_cancelled)
        self._all.set_visibility(gone > UNSAID_S)
        if compiling is None:
            left = max(1.0, USUAL_S - gone) if gone < USUAL_S else None
            wait = Wait(gone, left, is_late=left is None)
            self._said.set_text(CANCELS if cancels else MEASURES)
            self._left.set_text(said_of(wait))
            fill(self._share, wait.share)
        else:
            left = compiling.left_s(now)
            self._said.set_text(CANCELS if cancels else COMPILES)
            self._left.set_text(f"{compiling.words}; {gone:.0f} s gone{left_words(left)}.")
            fill(self._share, compiling.share)

    async def _on_cancel(self) -> None:
        self._cancels = True
        self._show()
        await self._desk.act(lambda: self._desk.daemon.cancel_analysis(self._shot.id))


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
        desk.films.earlier(shot)
        if shot.frames:
            desk.films.film(shot)


def film(
    desk: Desk, shot: ShotRecord, *, start: int | None = None, keys: bool = False
) -> Player | None:
    """Place the film of a shot and return it, or say why there is none and return None.

    It begins at frame `start`; without it where the shot was refused, or at the contact.
    """
    if not shot.frames:
        waiting = WAITED_FOR.get(shot.state, shot.failure or "no frames were stored")
        ui.label(f"No film: {waiting}.").classes("empty")
        return None
    try:
        found = desk.films.film(shot)
    except RigError as error:
        ui.label(error.sentence()).classes("empty")
        return None
    if found.blank:
        _told(
            "Nothing stands out in these frames.",
            "See whether the lens is covered, the lamp is lit and the tubes were loaded.",
            testid="blank",
        )
    player = Player(found.size, keys=keys)
    _load(player, desk, shot, found, start)
    return None if found.blank else player


def in_place(desk: Desk, player: Player, shot: ShotRecord) -> bool:
    """Show another film in a player that stands already, which costs a tenth of a new one.

    False: this film needs more than that, and nothing has changed.
    """
    try:
        found = desk.films.film(shot) if shot.frames else None
    except RigError:
        return False
    if found is None or found.blank or found.size != player.size:
        return False
    _load(player, desk, shot, found, None)
    return True


def _load(player: Player, desk: Desk, shot: ShotRecord, found: Film, start: int | None) -> None:
    if start is None and found.overlays.contact_frame is None:
        start = desk.films.result(shot).get("frame", found.brightest)
    player.load(shot, found.overlays, found.times_s, start=start)


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
        if said := measured_again(result, desk.films.earlier(shot)):
            ui.label(said).classes("note").props("data-testid=measured-again")
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


def measured_again(now: Json, before: Json) -> str:
    """Say what a further analysis has changed of e and beta, and with what; empty if nothing."""
    if before.get("status") != "measured":
        return ""
    changed = []
    for name in AGAIN_SAID:
        was, is_now = (
            measured(COEFFICIENTS[name], one.get(name)).cells[1] for one in (before, now)
        )
        if was != is_now:
            changed.append(f"{COEFFICIENTS[name].name} was {was}, is {is_now}")
    # A value and its error stand on one line.
    changed = [one.replace(" ± ", "\u00a0±\u00a0") for one in changed]
    if not changed:
        return ""
    learned = now["method"] == before["method"] == "photometric"
    how = (
        "with what is known of its spheres by now" if learned else f"by the method {now['method']}"
    )
    return f"Measured again, {how}: {'; '.join(changed)}."


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
