"""The dialogs that want a reason, or a second word, before something is done."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from rigctl.page.parts.widgets import button


def ask_reason(title: str, text: str, verb: str, act: Callable[[str], Awaitable[bool]]) -> None:
    """Open a dialog with a field for the reason.

    Parameters
    ----------
    verb
        On the button, which is dead while the field is empty.
    act
        Is given the reason; the dialog closes if it says that it was done.
    """

    async def go() -> None:
        if await act(str(reason.value).strip()):
            dialog.close()

    with ui.dialog(value=True) as dialog, ui.card().classes("ask"):
        ui.label(title).classes("title")
        ui.label(text)
        reason = ui.input("Reason").classes("wide")
        reason.props("autofocus data-testid=reason outlined")
        with ui.element("div").classes("beside ends"):
            button("Cancel", dialog.close)
            done = button(verb, go, look="fill", testid=f"{verb.lower()}-now")
            done.bind_enabled_from(reason, "value", lambda given: bool((given or "").strip()))
    dialog.on("hide", dialog.delete)


def ask_again(title: str, text: str, verb: str, act: Callable[[], Awaitable[None] | None]) -> None:
    """Open a dialog that states what `act` does for good; its button `verb` does it."""

    async def go() -> None:
        dialog.close()
        if (waits := act()) is not None:
            await waits

    with ui.dialog(value=True) as dialog, ui.card().classes("ask").props("data-testid=ask-again"):
        ui.label(title).classes("title")
        ui.label(text)
        with ui.element("div").classes("beside ends"):
            button("Cancel", dialog.close).props("autofocus")
            button(verb, go, look="fill", testid=f"{verb.lower()}-now")
    dialog.on("hide", dialog.delete)
