"""The film of a shot: a strip, one frame in full, and the keys of the recorder's keypad."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

from nicegui import events, ui

from rigctl.page.parts.tables import minus
from rigctl.page.parts.widgets import button
from rigctl.page.shots.film import frame_address, strip_address
from rigctl.page.shots.overlay import LAYERS, Overlays
from rigctl.store import ShotRecord

MOST = 10
"""So many frames are shown; the style sheet has a rule for each place that is marked."""
CHOSEN = """(event) => {
  const frame = event.target.closest("[data-frame]");
  if (frame) emit(Number(frame.dataset.frame));
}"""


def frames_about(contact: int, count: int) -> list[int]:
    """Return frames about the contact, farther apart the farther away, of so many in a film."""
    reach = (MOST - 1) // 2
    offsets = (round(0.5 * k * abs(k)) + 2 * k for k in range(-reach - 1, reach + 1))
    return [contact + by for by in offsets if 0 <= contact + by < count]


class Strip:
    """Frames of a film beside one another; placed where it is made.

    A page that follows a sweep draws one for each shot: elements of the page library for every
    frame, and a request for each of their pictures, would hold up what the daemon does beside it.

    Parameters
    ----------
    chosen
        Called with the frame that was pressed.
    """

    def __init__(self, chosen: Callable[[int], object]) -> None:
        self._frames: Sequence[int] = ()
        self._marked = ""
        self._all = ui.html("", sanitize=False).classes("strip")

        def choose(event: events.GenericEventArguments) -> None:
            chosen(int(event.args))

        self._all.on("click", choose, js_handler=CHOSEN)

    def draw(
        self, shot: str, size: tuple[int, int], frames: Sequence[int], captions: Sequence[str]
    ) -> None:
        """Show frames of a shot.

        Parameters
        ----------
        size
            Columns and rows of a frame.
        frames
            Numbers of the frames shown, at most `MOST`.
        captions
            What stands below each.
        """
        self._frames, count = frames, len(frames)
        picture = f"background-image: url({strip_address(shot, self._frames)}); "
        whole = f"background-size: {100 * count}% 100%; aspect-ratio: {size[0]} / {size[1]}"
        self._all.set_content(
            "".join(
                f'<button class="frame" data-frame="{frame}" aria-label="show frame {frame}">'
                f'<i style="{picture}{whole}; '
                f'background-position: {100 * place / max(count - 1, 1):.4f}% 0"></i>'
                f"{escape(caption)}</button>"
                for place, (frame, caption) in enumerate(zip(frames, captions, strict=True))
            )
        )

    def mark(self, frame: int) -> None:
        """Mark the frame that is shown in full, where it is one of the strip."""
        marked = f"now-{self._frames.index(frame) + 1}" if frame in self._frames else ""
        if marked != self._marked:
            self._all.classes(remove=self._marked or None, add=marked or None)
            self._marked = marked


SPEEDS = {2: "2 per s", 5: "5 per s", 10: "10 per s", 20: "20 per s"}
JOG = 10
WHOLE_MS = 0.9
"""Frames that are farther apart than this, ms, are distinguished by whole milliseconds."""
HELP = {
    "outlines": "circle fitted to each sphere's edge: a sky blue, b orange",
    "markers": "dots on the spheres that were found, from which their turning follows",
    "tracks": "path of each centre up to this frame",
    "normal": "yellow: line of centres at first touch, from a to b (dot)",
}
LABELS = {"normal": "line of centres (yellow)"}
"""Of layers whose own name says less."""


class Player:
    """Shows one shot; placed where it is made. `load` puts another in its place.

    Parameters
    ----------
    size
        Columns and rows of a frame.
    keys
        Whether arrows and the space bar of the keyboard step and play.
    """

    def __init__(self, size: tuple[int, int], *, keys: bool = False) -> None:
        self.size = size
        self._shot: ShotRecord | None = None
        self._overlays, self._times = Overlays.of({}), tuple[float, ...]()
        self._contact = self._frame = 0
        self._layers = [layer for layer in LAYERS if layer != "tracks"]
        with ui.element("div").props("role=img").classes("wide") as self._named:
            self._picture = ui.interactive_image(size=size, sanitize=False).classes("film")
        self._picture.props("data-testid=film aria-hidden=true")
        self._strip = Strip(self.show)
        self._keypad()
        self._playing = ui.timer(0.1, lambda: self.step(1, around=True), active=False)
        if keys:
            ui.keyboard(on_key=self._on_key)

    def load(
        self,
        shot: ShotRecord,
        overlays: Overlays,
        times_s: Sequence[float],
        *,
        start: int | None = None,
    ) -> None:
        """Show a shot whose frames have the same size.

        Parameters
        ----------
        shot
            With stored frames.
        overlays
            What the analysis found.
        times_s
            Time of each frame from the mark, s.
        start
            Frame shown first; None: the contact. Without a contact the strip lies about it.
        """
        self._shot, self._overlays, self._times = shot, overlays, tuple(times_s)
        contact = overlays.contact_frame
        self._contact = self._within(start or 0 if contact is None else contact)
        frames = frames_about(self._contact, len(self._times))
        self._strip.draw(shot.id, self.size, frames, [self._caption(frame) for frame in frames])
        self._playing.active = False
        self._play_key.set_text("Play")
        self.show(self._contact if start is None else start)

    def show(self, frame: int) -> None:
        """Show a frame, counted from 0; one beyond the film is its last or first."""
        if self._shot is None:
            return
        self._frame = self._within(frame)
        self._picture.set_source(frame_address(self._shot.id, self._frame))
        self._picture.set_content(self._overlays.drawing(self._frame, self._layers))
        self._where.set_text(self._said())
        self._named.props(f'aria-label="film of shot {self._shot.number}, {self._said()}"')
        self._strip.mark(self._frame)

    def step(self, by: int, *, around: bool = False) -> None:
        """Go some frames on, or back; `around` begins anew after the last."""
        frame = self._frame + by
        self.show(frame % len(self._times) if around else frame)

    def _said(self) -> str:
        words = f"frame {self._frame} of 0–{len(self._times) - 1}"
        since = self._since(self._frame)
        if since is None:
            return words
        if self._frame == self._contact:
            return f"{words}, at contact"
        side = "after" if since > 0 else "before"
        return f"{words}, {abs(since):.1f} ms {side} contact"

    def _since(self, frame: int) -> float | None:
        """Return the time of a frame from that of the contact, ms; None where no contact is known.

        Times from any other frame would change when the contact is found.
        """
        if self._overlays.contact_frame is None:
            return None
        return 1e3 * (self._times[frame] - self._times[self._contact])

    def _caption(self, frame: int) -> str:
        since = self._since(frame)
        if since is None:
            return f"frame {frame}"
        if frame == self._contact:
            return "contact"
        step = 1e3 * (self._times[-1] - self._times[0]) / max(len(self._times) - 1, 1)
        return minus(f"{since:+.{0 if step >= WHOLE_MS else 1}f} ms")

    def _within(self, frame: int) -> int:
        return min(max(frame, 0), len(self._times) - 1)

    def _keypad(self) -> None:
        with ui.element("div").classes("keys"):
            keys = (("≪ jog", -JOG), ("◀ step", -1), ("step ▶", 1), ("jog ≫", JOG))
            for name, by in keys[:2]:
                self._key(name, by)
            self._play_key = button("Play", self._play, testid="play")
            for name, by in keys[2:]:
                self._key(name, by)
            speed = ui.select(SPEEDS, value=10, on_change=self._set_speed)
            speed.props('dense outlined options-dense aria-label="frames shown per second"')
            with ui.element("div").classes("keys"):
                for layer in LAYERS:
                    self._layer(layer)
        self._where = ui.label().classes("note").props("data-testid=where")

    def _layer(self, name: str) -> None:
        box = (
            ui.checkbox(LABELS.get(name, name), value=name in self._layers)
            .props("dense")
            .tooltip(HELP[name])
        )
        box.on_value_change(lambda event: self._switch(name, on=bool(event.value)))

    def _key(self, name: str, by: int) -> None:
        button(name, lambda: self.step(by))

    def _play(self) -> None:
        self._playing.active = not self._playing.active
        self._play_key.set_text("Pause" if self._playing.active else "Play")

    def _set_speed(self, event: events.ValueChangeEventArguments[int]) -> None:
        self._playing.interval = 1 / float(event.value)

    def _switch(self, layer: str, *, on: bool) -> None:
        kept = set(self._layers) | {layer} if on else set(self._layers) - {layer}
        self._layers = [each for each in LAYERS if each in kept]
        self.show(self._frame)

    def _on_key(self, event: events.KeyEventArguments) -> None:
        if not event.action.keydown:
            return
        if event.key.arrow_left:
            self.step(-1)
        elif event.key.arrow_right:
            self.step(1)
