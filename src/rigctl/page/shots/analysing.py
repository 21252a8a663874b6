"""The wait for a shot's coefficients: its step, seconds gone and left, and a way out of it."""

from __future__ import annotations

import time

from nicegui import ui

from rigctl.jobs.duration import WRONG_BY, Rate, Wait
from rigctl.page.desk import Desk
from rigctl.page.parts.presence import every
from rigctl.page.parts.waiting import UNSAID_S, said_of
from rigctl.page.parts.widgets import button
from rigctl.store import ShotRecord

LOOK_S = 0.25
USUAL_S = 4.0
"""Of a shot of some twenty frames on a small computer, its worker's start with it, s."""
COMPILES = "Machine code is being compiled, once on this host: it takes a minute or two"
MEASURES = "Measuring its frames"
CANCELS = "It is being cancelled"


class Analysing:
    """Placed where the coefficients will stand, seen once the analysis lasts longer than a second.

    Seconds count from when the daemon queued it, so that a page that is reloaded counts on.
    Cancelled, the shot keeps its frames, and the host the machine code that was compiled by then.
    """

    def __init__(self, desk: Desk, shot: ShotRecord) -> None:
        self._desk, self._shot = desk, shot
        self._drawn_s, self._rate, self._cancels = time.monotonic(), Rate(), False
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
            left = max(1.0, USUAL_S - gone) if gone < WRONG_BY * USUAL_S else None
            self._said.set_text(CANCELS if cancels else MEASURES)
            self._left.set_text(said_of(Wait(gone, left)))
        else:
            left = self._rate.left_s(compiling.share, now)
            self._said.set_text(CANCELS if cancels else COMPILES)
            about = "" if left is None else f", about {left:.0f} s left"
            self._left.set_text(f"{compiling.words}; {gone:.0f} s gone{about}.")
        share = Wait(gone, left).share
        self._share.set_value(round(share or 0.0, 2))

    async def _on_cancel(self) -> None:
        self._cancels = True
        self._show()
        await self._desk.act(lambda: self._desk.daemon.cancel_analysis(self._shot.id))
