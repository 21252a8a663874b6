"""The wait for a shot's coefficients: a cancelled one stays cancelled, a reloaded one counts on."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from nicegui import Client, ui

from rigctl.measuring.analysing import Awaited
from rigctl.page.shots import view as module
from rigctl.page.shots.view import Analysing, left_words


class Daemon:
    """As much of a daemon as is asked: how the shot's analysis stands."""

    def __init__(self) -> None:
        self.stands: Awaited | None = Awaited(37.2, is_cancelled=False)

    def awaited(self, shot: str) -> Awaited | None:
        return self.stands

    def compiling(self) -> None:
        return None

    def cancel_analysis(self, shot: str) -> None:
        self.stands = Awaited(38.0, is_cancelled=True)


class Drawn:
    """The part on a page, and what is called every so often."""

    def __init__(self, daemon: Daemon, monkeypatch: pytest.MonkeyPatch) -> None:
        looks = list[Callable[[], None]]()
        self.meanwhile = ""
        monkeypatch.setattr(module, "every", lambda _period_s, look: looks.append(look))

        async def act(go: Callable[[], None]) -> None:
            # A busy daemon: the page looks once more before the order is given.
            looks[0]()
            self.meanwhile = self.texts[0]
            go()

        desk: Any = SimpleNamespace(daemon=daemon, act=act)
        shot: Any = SimpleNamespace(id="20260131-000001")
        with Client(ui.page("/shot")) as self._client:
            self._part = Analysing(desk, shot)
        self.look = looks[0]

    def cancel(self) -> None:
        asyncio.run(self._part._on_cancel())

    @property
    def texts(self) -> list[str]:
        elements = self._client.elements.values()
        return [x.text for x in elements if isinstance(x, ui.label)]


def test_a_page_that_is_drawn_later_counts_the_seconds_on(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = Drawn(Daemon(), monkeypatch)
    drawn.look()
    assert drawn.texts[0] == "Measuring its frames"
    assert "37 s gone" in drawn.texts[1]


def test_a_cancelled_analysis_is_said_to_be_until_it_has_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    drawn = Drawn(Daemon(), monkeypatch)
    drawn.look()
    drawn.cancel()
    drawn.look()
    assert drawn.meanwhile == drawn.texts[0] == "It is being cancelled"
    reloaded = Drawn(daemon := Daemon(), monkeypatch)
    daemon.cancel_analysis("20260131-000001")
    reloaded.look()
    assert reloaded.texts[0] == "It is being cancelled"


@pytest.mark.parametrize(
    ("share", "left_s", "said"),
    [
        (0.1, 103.0, ""),
        (0.3, 177.0, ""),
        (0.5, None, ""),
        (0.5, 138.0, ", some 3 min left"),
        (0.6, 121.0, ", some 3 min left"),
        (0.7, 119.0, ", some 2 min left"),
        (0.9, 40.0, ", less than a minute left"),
    ],
)
def test_the_end_of_compiling_is_told_in_minutes_once_the_pace_says_it(
    share: float, left_s: float | None, said: str
) -> None:
    assert left_words(share, left_s) == said
