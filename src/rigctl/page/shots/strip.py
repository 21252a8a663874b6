"""The strip of frames below a film: one element and one picture, however many frames it shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

from nicegui import events, ui

from rigctl.page.shots.film import strip_address

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
