"""The tape recorder on the page: its keypad, its tape, and the picture on which it stands."""

from __future__ import annotations

import base64
from collections.abc import Callable
from functools import partial

from nicegui import ui

from rigctl.cameras.keypad import Keypad, KeypadStatus
from rigctl.errors import RigError, SettingsError
from rigctl.page.desk import Desk, actor
from rigctl.page.layout import sheet
from rigctl.page.parts.asking import ask_again
from rigctl.page.parts.presence import every, kept_page
from rigctl.page.parts.tables import minus
from rigctl.page.parts.widgets import button
from rigctl.rig.tape import erase_tape
from rigctl.service.pictures import png

PLACE = "/recorder"
LOOK_S = 1.0
SPEEDS = (-30, -10, -5, -1, 1, 5, 10, 30)


def recorder_page(desk: Desk) -> None:
    """Register the page at `/recorder`."""

    @kept_page(PLACE)
    def page() -> None:
        with sheet(desk, "Recorder", "/"):
            ui.html("Recorder", sanitize=False, tag="h2").classes("own-heading")
            keypad = desk.daemon.keypad
            if keypad is None:
                ui.label("This rig's camera is no tape recorder.").classes("empty")
                return
            Keys(desk, keypad)


class Keys:
    """The keypad; what stands above it is asked of the recorder every second."""

    def __init__(self, desk: Desk, keypad: Keypad) -> None:
        self._desk, self._keypad = desk, keypad
        with ui.element("div").classes("panel"):
            self._stands = ui.label("").props("data-testid=recorder-state role=status")
            self._tape = ui.label("").classes("note").props("data-testid=tape")
            self._keys()
            self._search_fields()
            self._viewing()
        with ui.element("div").classes("panel"):
            ui.label("Picture").classes("title")
            self._picture = ui.image("").props('data-testid=still alt="picture on the tape"')
            self._picture.style("max-width: 720px; image-rendering: pixelated")
            self._picture.set_visibility(False)
            button("Show the picture", self._still, testid="show-picture")
        every(LOOK_S, self._look)

    def _keys(self) -> None:
        keypad = self._keypad
        plain: dict[str, Callable[[], None]] = {
            "Live": keypad.live,
            "Record": keypad.record,
            "Stop tape": keypad.stop,
            "Replay": keypad.replay,
            "Play": keypad.play,
            "Step back": partial(keypad.step, -1),
            "Step": partial(keypad.step, 1),
        }
        with ui.element("div").classes("beside"):
            for name, key in plain.items():
                testid = f"key-{name.lower().replace(' ', '-')}"
                button(name, partial(self._press, key), testid=testid)
            button("Erase …", self._ask_erase, testid="key-erase")
        with ui.element("div").classes("beside"):
            ui.label("Jog, pictures a second").classes("note")
            for speed in SPEEDS:
                jog = partial(keypad.jog, speed)
                button(minus(f"{speed:+d}"), partial(self._press, jog), testid=f"jog{speed:+d}")

    def _search_fields(self) -> None:
        with ui.element("div").classes("beside fields"):
            self._session = ui.number("session", precision=0).props("dense outlined")
            self._kind = ui.select(
                {
                    "none": "its first picture",
                    "frame": "frame",
                    "mark": "mark",
                    "time_s": "time, s",
                },
                value="frame",
                label="search for",
            ).props("dense outlined data-testid=search-kind")
            self._place = ui.number("number").props("dense outlined data-testid=search-place")
            button("Search", self._search, testid="key-search")

    def _viewing(self) -> None:
        with ui.element("div").classes("beside fields"):
            self._gamma = ui.number("gamma, 0.1 to 1", value=1.0, step=0.1)
            self._gamma.props("dense outlined data-testid=gamma")
            button("Set gamma", self._set_gamma, testid="key-gamma")
            agreed = ui.switch("A shot may erase a tape without room for it")
            agreed.props("data-testid=when-full")
            self._agreed = agreed
            agreed.on("click", lambda: self._press(self._agree))

    def _agree(self) -> None:
        self._keypad.agree(erases_when_full=bool(self._agreed.value))

    async def _press(self, key: Callable[[], object]) -> None:
        def work() -> KeypadStatus:
            key()
            return self._keypad.status()

        found = await self._desk.act(work, moves=True)
        if found is not None:
            self._show(found)

    async def _look(self) -> None:
        if self._desk.daemon.rig.status().running is not None:
            self._stands.set_text("The recorder belongs to the shot under way.")
            return
        try:
            self._show(await self._desk.lanes.control(self._keypad.status))
        except RigError as error:
            self._stands.set_text(error.sentence())

    def _show(self, found: KeypadStatus) -> None:
        at = ""
        if found.picture is not None and found.picture_s is not None:
            at = f", on picture {found.picture} ({found.picture_s:.4f} s)"
        self._stands.set_text(
            f"{found.mode}: session {found.session} with {found.pictures} pictures{at}"
        )
        pictures = "picture" if len(found.marks) == 1 else "pictures"
        marks = ", ".join(map(str, found.marks))
        self._tape.set_text(
            f"Tape {found.place}, {len(found.sessions)} sessions, {found.seconds_left:.1f} s left; "
            f"a shot needs {found.needed_s:.1f} s. "
            + (f"The session is marked at {pictures} {marks}." if marks else "No mark.")
        )
        self._agreed.set_value(found.erases_when_full)

    async def _search(self) -> None:
        kind, place, session = str(self._kind.value), self._place.value, self._session.value

        def key() -> None:
            chosen = {} if kind == "none" or place is None else {kind: place}
            if "time_s" not in chosen:
                chosen = {name: _whole(name, value) for name, value in chosen.items()}
            number = None if session is None else _whole("session", session)
            self._keypad.search(session=number, **chosen)

        await self._press(key)
        await self._still()

    async def _set_gamma(self) -> None:
        asked = self._gamma.value

        def key() -> None:
            if asked is None:
                raise SettingsError("is empty", part="gamma", todo="enter 0.1 to 1")
            self._keypad.gamma(float(asked))

        await self._press(key)

    def _ask_erase(self) -> None:
        who, store = actor(), self._desk.daemon.store
        ask_again(
            "Erase the tape",
            "All its sessions are lost. What shots have stored stays.",
            "Erase",
            lambda: self._press(lambda: erase_tape(self._keypad, store, who)),
        )

    async def _still(self) -> None:
        frames = await self._desk.act(self._keypad.still)
        if frames is not None:
            data = base64.b64encode(png(frames.pixels[0])).decode()
            self._picture.set_source(f"data:image/png;base64,{data}")
            self._picture.set_visibility(True)


def _whole(name: str, value: float) -> int:
    """Return a whole number; raise `SettingsError` for any other."""
    if value != int(value):
        raise SettingsError(
            "is no whole number", part=name, value=f"{value:g}", todo="correct the number"
        )
    return int(value)
