"""Puts the page beside the REST application, in one server."""

from __future__ import annotations

import gc
from functools import partial
from pathlib import Path

from fastapi import FastAPI
from fastapi.middleware.gzip import GZipMiddleware
from nicegui import ui
from starlette.types import ASGIApp

from rigctl.daemon import Daemon
from rigctl.page.campaigns.output import report_route
from rigctl.page.campaigns.pages import campaign_pages
from rigctl.page.desk import Desk
from rigctl.page.feed import Feed
from rigctl.page.model.pages import model_pages
from rigctl.page.model.story.cards import drawings_route
from rigctl.page.own.downloads import downloads_route
from rigctl.page.own.dropping import dropping_route
from rigctl.page.own.pages import own_pages
from rigctl.page.parts.fonts import fonts_route
from rigctl.page.parts.plotting import plotting_route
from rigctl.page.parts.presence import rest_while
from rigctl.page.parts.readings import Readings
from rigctl.page.rig.commissioning import commissioning_page
from rigctl.page.rig.film import film_page, shot_film_route
from rigctl.page.rig.pages import rig_page
from rigctl.page.rig.recorder import recorder_page
from rigctl.page.session_auth import SessionAuth
from rigctl.page.shots.film import film_route
from rigctl.page.shots.films import Films
from rigctl.page.shots.pages import shot_pages
from rigctl.page.sweeps.pages import sweep_pages
from rigctl.service.lanes import Lanes

STYLE = Path(__file__).with_name("style.css")
SILENT_S = 15.0
"""About so long after a connection went silent either side takes it for lost and makes another. A
page that hears nothing covers itself long before, and is kept far longer."""
REPEATED = 20_000
"""So many changes that a browser has not acknowledged are repeated to it; where one is missing, the
page library loads the page anew. A page that follows a sweep gets some fifty in a second."""
PACKING = 1
"""How hard files are packed, 1 to 9: more holds the daemon up longer than it saves a network."""


def with_page(api: FastAPI, daemon: Daemon) -> ASGIApp:
    """Return what a server runs: the page for those with a session, REST for those with a key.

    Called once in a process: pages are registered in the page library's one table.
    """
    lanes, of_rest = Lanes(), api.state.lanes
    rest_while(lambda: lanes.is_firing, lambda: of_rest.is_firing)
    desk = Desk(daemon, lanes, Feed(daemon), Readings(daemon.store), Films(daemon.store))
    ui.add_css(STYLE, shared=True)
    rig = (rig_page, commissioning_page, recorder_page, film_page)
    for register in (*rig, shot_pages, sweep_pages, campaign_pages, model_pages, own_pages):
        register(desk)
    shell = FastAPI(openapi_url=None, lifespan=api.router.lifespan_context)
    plotting_route(shell)
    film_route(shell, desk)
    report_route(shell, desk)
    drawings_route(shell)
    fonts_route(shell)
    downloads_route(shell, desk)
    dropping_route(shell, desk)
    shot_film_route(shell, desk)
    ui.run_with(
        shell,
        title="rigctl",
        language="en-US",
        dark=None,
        tailwind=False,
        show_welcome_message=False,
        reconnect_timeout=SILENT_S,
        message_history_length=REPEATED,
        gzip_middleware_factory=partial(GZipMiddleware, compresslevel=PACKING),
    )
    # What is loaded by now is never garbage; to look through it holds everything up for 0.2 s.
    gc.collect()
    gc.freeze()
    return SessionAuth(api, shell, api.state.keyring, api.state.wrong_keys)
