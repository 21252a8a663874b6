"""Parts of a page that follow the daemon, and say so when they cannot."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from rigctl.errors import RigError
from rigctl.page.parts.presence import every


def following(period_s: float, look: Callable[[], Awaitable[None] | None]) -> None:
    """Call `look` again and again; while it fails, say that what stands here is old, and why.

    Parameters
    ----------
    period_s
        Rest between two calls, s; a call that takes longer delays the next one.
    look
        Reads the daemon and draws what has changed; may be a coroutine function.
    """
    old = ui.label().classes("verdict bad old").props("role=alert data-testid=old")
    old.set_visibility(False)

    async def go() -> None:
        try:
            waits = look()
            if waits is not None:
                await waits
        except RigError as error:
            old.set_text(f"What is shown here is old: {error.sentence()}")
            old.set_visibility(True)
        else:
            old.set_visibility(False)

    every(period_s, go)
