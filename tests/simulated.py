"""The default rig, whose short films show no spheres: for tests that fire and measure nothing."""

from __future__ import annotations

from pathlib import Path

from rigctl.config import Configuration, StoreSection, load

FRAMES_AFTER_MARK = 15
"""Spheres come into the picture some 50 ms after the fire."""


def with_short_films(folder: Path | str) -> Configuration:
    """Return the default configuration with a store in a folder and films of 15 ms."""
    usual = load()
    camera = usual.camera.model_copy(update={"frames_after_mark": FRAMES_AFTER_MARK})
    return usual.model_copy(update={"store": StoreSection(folder=str(folder)), "camera": camera})
