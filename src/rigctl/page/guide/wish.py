"""Whether this browser wants the guide: one cookie, set when it does not."""

from __future__ import annotations

from nicegui import context, ui

COOKIE = "rigctl_guide"
HIDDEN = "hidden"
YEAR_S = 365 * 86_400


def wanted() -> bool:
    """Say whether the guide is shown on the page that is being built."""
    return context.client.request.cookies.get(COOKIE) != HIDDEN


def keep(*, shown: bool) -> None:
    """Remember in this browser whether the guide is shown from the next page on."""
    value, age = ("", 0) if shown else (HIDDEN, YEAR_S)
    ui.run_javascript(f'document.cookie = "{COOKIE}={value}; path=/; max-age={age}; SameSite=Lax"')
