"""Several films are measured by what was stated at the start, and by no length that cannot be."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from nicegui import Client, core, ui

from rigctl.jobs import Job, JobState
from rigctl.page.own import film, look, measuring
from rigctl.page.own.brought import Brought
from rigctl.page.own.film import FilmView
from rigctl.page.own.marks import Marks
from rigctl.page.parts import waiting

AT = datetime(2026, 1, 1, tzinfo=UTC)


class Jobs:
    """Takes jobs and ends them as failed when it is told to."""

    def __init__(self) -> None:
        self.by_id: dict[str, Job] = {}

    def submit(self, kind: str, subject: str, work: object) -> Job:
        name = str(len(self.by_id))
        self.by_id[name] = Job(name, kind, subject, JobState.RUNNING, AT)
        return self.by_id[name]

    def job(self, name: str) -> Job:
        return self.by_id[name]

    def jobs(self) -> list[Job]:
        return list(self.by_id.values())

    def fail(self) -> None:
        for name, job in self.by_id.items():
            self.by_id[name] = replace(job, state=JobState.FAILED, failure="it is dark")


class Drawn:
    """The view of two films, what its measurements were asked, and its fields by their names."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.asked: list[dict[str, Any]] = []
        self.jobs = Jobs()

        def in_process(function: str, asked: dict[str, Any]) -> Callable[[], None]:
            self.asked.append(asked)
            return lambda: None

        monkeypatch.setattr(measuring, "in_process", in_process)
        for module in (film, look, waiting):
            monkeypatch.setattr(module, "following", lambda *given: None, raising=False)
        desk: Any = SimpleNamespace(daemon=SimpleNamespace(jobs=self.jobs))
        brought = Brought(folder, films=(folder / "1.mp4", folder / "2.mp4"))
        with Client(ui.page("/own")) as self._client:
            self.view = FilmView(desk, brought)

    def field(self, testid: str) -> Any:
        elements = self._client.elements.values()
        return next(x for x in elements if x.props.get("data-testid") == testid)

    async def state_length(self, length_mm: float) -> None:
        field = self.field("line-mm")
        field.set_value(length_mm)
        with self._client:
            for heard in list(field._event_listeners.values()):
                if heard.type == "change":
                    heard.handler()
        await drawn_anew()

    def measure(self) -> None:
        with self._client:
            self.view._start()

    def follow(self) -> None:
        with self._client:
            self.view._follow()


async def drawn_anew() -> None:
    """Wait until the parts that follow a field are drawn anew, as they are by tasks."""
    for _ in range(20):
        await asyncio.sleep(0)


def on_a_page(
    go: Callable[[Drawn], Awaitable[None]], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Go through a view in a loop, as a page has one that draws anew."""

    async def within() -> None:
        monkeypatch.setattr(core, "loop", asyncio.get_running_loop())
        await go(Drawn(folder, monkeypatch))

    asyncio.run(within())


def test_what_is_changed_while_films_are_measured_holds_for_none_of_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def go(drawn: Drawn) -> None:
        drawn.field("ball-diameter-mm").set_value(40.0)
        drawn.field("ball-mass-g").set_value(2.7)
        await drawn_anew()
        drawn.measure()
        drawn.field("ball-diameter-mm").set_value(60.0)
        # No mass can be that: it would be taken for one that is not stated.
        drawn.field("ball-mass-g").set_value(-1.0)
        await drawn_anew()
        drawn.jobs.fail()
        drawn.follow()
        assert [one["shot"] for one in drawn.asked] == [1, 2]
        assert [(one["diameter_mm"], one["mass_g"]) for one in drawn.asked] == [(40.0, 2.7)] * 2

    on_a_page(go, tmp_path, monkeypatch)


def test_by_a_line_whose_length_cannot_be_nothing_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def go(drawn: Drawn) -> None:
        form, panel = drawn.view._form, drawn.view._look
        panel.marks = Marks(ring=(50.0, 50.0, 20.0), line=(0.0, 0.0, 80.0, 0.0))
        form.refresh()
        await drawn_anew()
        await drawn.state_length(160.0)
        assert form.ready
        await drawn.state_length(-5.0)
        assert not form.ready
        drawn.measure()
        assert drawn.asked == []
        await drawn.state_length(80.0)
        drawn.measure()
        (asked,) = drawn.asked
        assert asked["diameter_mm"] == pytest.approx(40.0)

    on_a_page(go, tmp_path, monkeypatch)
