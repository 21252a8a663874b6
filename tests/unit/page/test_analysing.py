"""The wait for a shot's coefficients: a cancelled one stays cancelled, a reloaded one counts on."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest
from nicegui import Client, ui

from rigctl.measuring.analysing import Awaited, Compiling
from rigctl.measuring.stored_shot import time_taken
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
    def bar(self) -> ui.linear_progress:
        (bar,) = (x for x in self._client.elements.values() if isinstance(x, ui.linear_progress))
        return bar

    @property
    def texts(self) -> list[str]:
        elements = self._client.elements.values()
        return [x.text for x in elements if isinstance(x, ui.label)]


def test_a_page_that_is_drawn_later_counts_the_seconds_on(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = Drawn(Daemon(), monkeypatch)
    drawn.look()
    assert drawn.texts[0] == "Measuring its frames"
    assert "37 s gone" in drawn.texts[1]


def test_a_bar_never_goes_back_when_measuring_lasts_longer_than_usual(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    drawn = Drawn(daemon := Daemon(), monkeypatch)
    daemon.stands = Awaited(3.0, is_cancelled=False)
    drawn.look()
    assert drawn.bar.value == pytest.approx(0.75)
    assert "indeterminate" not in drawn.bar.props
    daemon.stands = Awaited(4.5, is_cancelled=False)
    drawn.look()
    assert "indeterminate" in drawn.bar.props


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
    ("left_s", "said"),
    [
        (None, ""),
        (133.0, ", about 2 min left"),
        (90.0, ", about 1.5 min left"),
        (87.0, ", about 90 s left"),
        (31.0, ", about 40 s left"),
        (0.0, ", about 10 s left"),
    ],
)
def test_the_time_left_of_compiling_is_told_no_finer_than_it_is_known(
    left_s: float | None, said: str
) -> None:
    assert left_words(left_s) == said


# When so many functions of 187 were compiled, s; the first shot of a host, by its processor.
COMPILED_S = {19: 7.4, 39: 15.0, 56: 29.0, 75: 41.0, 100: 47.5, 131: 57.0, 150: 67.0, 182: 86.5}
LAST_S = 90.5


def test_the_time_left_of_compiling_falls_evenly_and_is_nearly_that_which_passes() -> None:
    told: list[float] = []
    far = {0.0: 0, **{at: count for count, at in COMPILED_S.items()}}
    for second in range(10, 90):
        at = max(time for time in far if time <= second)
        compiling = Compiling("", time_taken(far[at] / 187), at, at)
        left = compiling.left_s(float(second))
        if left is not None:
            told.append(left)
            assert abs(left - (LAST_S - second)) < 20.0
    assert len(told) > 60
    # A count of functions jumps by half a minute between two of these.
    assert max(b - a for a, b in pairwise(told)) < 12.0
