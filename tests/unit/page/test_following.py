"""A part of a page that cannot be read says that what it shows is old."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from rigctl.errors import StoreError
from rigctl.page.parts import following as module
from rigctl.page.parts.following import following


class Label:
    """As much of a label as is used."""

    text, visible = "", True

    def classes(self, _: str) -> Label:
        return self

    def props(self, _: str) -> Label:
        return self

    def set_text(self, text: str) -> None:
        self.text = text

    def set_visibility(self, visible: bool) -> None:
        self.visible = visible


class Page:
    """Keeps the label and what is to be called every so often."""

    go: Callable[[], Awaitable[None]]

    def __init__(self) -> None:
        self.said = Label()

    def label(self) -> Label:
        return self.said

    def every(self, _: float, go: Callable[[], Awaitable[None]]) -> None:
        self.go = go

    def tick(self) -> None:
        asyncio.run(self.go())


@pytest.fixture
def page(monkeypatch: pytest.MonkeyPatch) -> Page:
    placed = Page()
    monkeypatch.setattr(module, "ui", placed)
    monkeypatch.setattr(module, "every", placed.every)
    return placed


class Daemon:
    """Answers, or refuses."""

    broken = False

    def look(self) -> None:
        if self.broken:
            raise StoreError("the catalogue is locked", part="catalogue.db", todo="end the other")

    async def look_later(self) -> None:
        self.look()


@pytest.mark.parametrize("way", ["look", "look_later"])
def test_what_cannot_be_read_is_called_old_until_it_can_be_read_again(page: Page, way: str) -> None:
    daemon = Daemon()
    following(0.1, getattr(daemon, way))
    page.tick()
    assert not page.said.visible
    daemon.broken = True
    page.tick()
    assert page.said.visible
    assert "is old" in page.said.text
    assert "the catalogue is locked" in page.said.text
    daemon.broken = False
    page.tick()
    assert not page.said.visible


def test_a_fault_of_the_program_itself_is_not_taken_for_silence(page: Page) -> None:
    def look() -> Any:
        raise KeyError("a fault")

    following(0.1, look)
    with pytest.raises(KeyError):
        page.tick()
