"""The plotting library that browsers load: the part of plotly.js that draws plots with two axes.

The page library would send the whole of it, with globes, maps and surfaces; browsers take a second
to read that.
"""

from __future__ import annotations

import gzip
from functools import cache
from pathlib import Path

from fastapi import FastAPI, Request
from nicegui import ui
from nicegui.dependencies import register_importmap_override
from starlette.responses import Response

LIBRARY = Path(__file__).with_name("plotly") / "plotly-cartesian.min.js"
VERSION = "3.7.0"
ADDRESS = f"/plotly/{VERSION}/plotly.js"
ASKED_AS = "nicegui-plotly"
"""Name under which the page library's element for plots imports it."""
AS_MODULE = b"""
const shown = (plot) => !["", "none"].includes(getComputedStyle(plot).display);
const resize = async (plot) => (shown(plot) ? window.Plotly.Plots.resize(plot) : plot);
export const Plotly = { ...window.Plotly, Plots: { ...window.Plotly.Plots, resize } };
"""
"""The library is a script that leaves its name in the window; the element imports a module. It
refuses to fit a plot into a panel that is not shown; such a plot is fitted when it is shown."""
FOREVER = {"Cache-Control": "public, max-age=31536000, immutable", "Vary": "Accept-Encoding"}


def plotting_route(app: FastAPI) -> None:
    """Register the library's route, and have every plot of every page drawn by it."""
    register_importmap_override(ASKED_AS, ADDRESS)

    @app.get(ADDRESS, include_in_schema=False)
    def library(request: Request) -> Response:
        packed = "gzip" in request.headers.get("accept-encoding", "")
        headers = {**FOREVER, "Content-Encoding": "gzip"} if packed else FOREVER
        content = _packed() if packed else _module()
        return Response(content, media_type="text/javascript", headers=headers)


def expect_plots() -> None:
    """Let the browser fetch the library while it still builds the page that will need it."""
    ui.add_head_html(f'<link rel="modulepreload" href="{ADDRESS}">')


def _module() -> bytes:
    return LIBRARY.read_bytes() + AS_MODULE


@cache
def _packed() -> bytes:
    """Return it as it travels; packed once, on a thread of its own, for all browsers."""
    return gzip.compress(_module(), compresslevel=6)
