"""The way of dropped files to the daemon: a field that takes them, and the route behind it."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from fastapi import FastAPI, Request
from nicegui import run, ui
from starlette.datastructures import UploadFile
from starlette.requests import ClientDisconnect
from starlette.responses import JSONResponse, Response

from rigctl.errors import AnalysisInputError, RigError
from rigctl.page.desk import Desk
from rigctl.page.own.brought import (
    MOST_BYTES,
    MOST_FILES,
    forget_unsettled,
    new_place,
    safe_name,
    settled,
    what_is_in,
)

ADDRESS = "/own-data"
SHOWN_AT = "/own"
SCRIPT = Path(__file__).with_name("drop.js")
CHUNK = 1024**2


def drop_field(address: str = ADDRESS) -> None:
    """Place the field that files are dropped on for a route, and what is said of them."""
    ui.add_head_html(f"<script>{SCRIPT.read_text('utf-8')}</script>")
    ui.html(
        '<label for="drop-files" class="strong">Drop files here, or choose them</label>'
        '<input type="file" id="drop-files" data-testid="drop" multiple '
        f'data-address="{address}" '
        'onchange="bringFiles(this)">'
        '<div class="waiting" data-testid="bringing" hidden><div class="beside">'
        '<span class="strong" role="status"></span>'
        '<button type="button" data-testid="cancel-bringing">Cancel</button>'
        '</div><progress max="1" value="0" aria-label="the files on their way"></progress>'
        '<span class="note"></span></div>'
        '<div role="alert" data-testid="own-failed" hidden></div>',
        sanitize=False,
    ).classes("drop-field")


def dropping_route(app: FastAPI, desk: Desk) -> None:
    """Register the route, beside the pages: it answers where the files are shown, or why not.

    What an earlier daemon had not taken in to its end is removed.
    """
    forget_unsettled(desk.daemon.store.path)

    @app.post(ADDRESS, include_in_schema=False)
    async def bring(request: Request) -> Response:
        place = None
        try:
            require_room(request)
            async with request.form(max_files=MOST_FILES) as form:
                place = new_place(desk.daemon.store.path)
                async with awaited(request):
                    for file in form.getlist("files"):
                        if isinstance(file, UploadFile):
                            await keep(file, place / safe_name(file.filename or ""))
                    found = await run.io_bound(what_is_in, place)
            # None: the daemon ends.
            token = "" if found is None else settled(place)
        except ClientDisconnect:
            return Response(status_code=400)
        except RigError as error:
            return JSONResponse({"detail": error.sentence()}, 422)
        finally:
            # Where it was refused or cancelled, nothing is kept; else this name is free.
            if place is not None:
                await run.io_bound(shutil.rmtree, place, ignore_errors=True)
        return JSONResponse({"address": f"{SHOWN_AT}?brought={token}"})


def require_room(request: Request) -> None:
    """Raise `AnalysisInputError` where what a browser sends is too large, or of no stated size."""
    stated = request.headers.get("content-length", "")
    if not stated.isdecimal() or int(stated) > MOST_BYTES:
        raise AnalysisInputError(
            "are too large",
            part="the files",
            value=f"{int(stated) / 1e6:.0f} MB" if stated.isdecimal() else "of unknown size",
            limit=f"{MOST_BYTES / 1e6:.0f} MB",
            todo="put them on the rig's computer and use rigctl analyse",
        )


@asynccontextmanager
async def awaited(request: Request) -> AsyncIterator[None]:
    """Raise `ClientDisconnect` after the block where the browser did not wait for its end.

    The request's body has been read before.
    """
    left = asyncio.ensure_future(request.receive())
    try:
        yield
        if left.done():
            raise ClientDisconnect
    finally:
        left.cancel()


async def keep(file: UploadFile, path: Path) -> None:
    """Write a file that a browser sends."""
    with path.open("wb") as kept:
        while part := await file.read(CHUNK):
            await run.io_bound(kept.write, part)
