"""The page's letters, fetched from the daemon like everything else."""

from __future__ import annotations

from pathlib import Path

from fastapi import FastAPI
from starlette.staticfiles import StaticFiles

HERE = Path(__file__).parent
PLACE = "/fonts"


def fonts_route(app: FastAPI) -> None:
    """Register the fonts; the style sheet names them."""
    app.mount(PLACE, StaticFiles(directory=HERE))
