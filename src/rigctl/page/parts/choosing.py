"""Buttons of which one is pressed, built once: a click on one that is drawn anew would be lost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

from nicegui import ui

from rigctl.page.parts.widgets import button

T = TypeVar("T")


def press(placed: ui.element, *, pressed: bool) -> None:
    """Say of a button whether it is the chosen one."""
    placed.props(f"aria-pressed={str(pressed).lower()}")


class Choice(Generic[T]):
    """A group of buttons, one for each option.

    Parameters
    ----------
    label
        Name of the group.
    options
        Words of each option, in the order drawn.
    chosen
        The one that is pressed; one that is no option presses none.
    choose
        Called with the option that was clicked, once it is pressed.
    testids
        Of the buttons, by option.
    """

    def __init__(
        self,
        label: str,
        options: Mapping[T, str],
        chosen: T,
        choose: Callable[[T], None],
        testids: Mapping[T, str] | None = None,
    ) -> None:
        self._choose = choose
        with ui.element("div").classes("beside").props(f'role=group aria-label="{label}"'):
            self._buttons = {
                option: button(
                    words,
                    lambda option=option: self._clicked(option),
                    look="line tab",
                    testid=(testids or {}).get(option, ""),
                )
                for option, words in options.items()
            }
        self.press(chosen)

    def press(self, chosen: T) -> None:
        """Show another option as the chosen one."""
        for option, placed in self._buttons.items():
            press(placed, pressed=option == chosen)

    def _clicked(self, option: T) -> None:
        self.press(option)
        self._choose(option)
