"""Keys that every page hears, and the list of them that `?` opens."""

from __future__ import annotations

from html import escape
from pathlib import Path

from nicegui import ui

KEYS = (
    ("Ctrl + .", "emergency stop, also while you type"),
    ("1 2 3 4", "to a step of a model's story"),
    ("Space", "play or halt the film"),
    ("← → ↑ ↓", "slider: one step; map: next cell; a shot's film: next picture"),
    ("Shift + ← →", "slider: ten steps"),
    ("Home, End", "slider: to its ends"),
    ("Enter", "map: show the points of the cell"),
    ("U", "undo the effect that was added last"),
    ("?", "this list"),
)


def to_step(step: int) -> str:
    """Return the script that goes to a step, as its key does."""
    return f"window.toStep({step})"


def list_keys() -> None:
    """Open the list of keys, as the key `?` does; a second press closes it."""
    ui.run_javascript("window.listKeys()")


def keys() -> None:
    """Have the page hear its keys, and place the list of them, closed."""
    script = Path(__file__).with_name("keys.js").read_text("utf-8")
    lines = "".join(
        f"<tr><th scope='row'><kbd>{escape(key)}</kbd></th><td>{escape(does)}</td></tr>"
        for key, does in KEYS
    )
    ui.add_body_html(
        f"<dialog id='keys' aria-labelledby='keys-title'><h2 id='keys-title'>Keys</h2>"
        f"<table>{lines}</table><form method='dialog'><button>Close</button></form></dialog>"
        f"<script>{script}</script>"
    )
