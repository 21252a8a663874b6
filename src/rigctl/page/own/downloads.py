"""What came of a film, as files that the browser fetches: figure, result, and campaign as ZIP."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

from fastapi import FastAPI
from starlette.responses import Response

from rigctl.errors import NotFoundError, RigError
from rigctl.page.desk import Desk
from rigctl.page.own.brought import CAMPAIGN, FIGURE, RESULT, known
from rigctl.service.problems import answer, from_error

ADDRESS = "/own-data"
TYPES = {FIGURE: "image/png", RESULT: "application/json", f"{CAMPAIGN}.zip": "application/zip"}


def downloads_route(app: FastAPI, desk: Desk) -> None:
    """Register the route, beside the pages; it gives nothing but the files of `TYPES`."""

    @app.get(ADDRESS + "/{token}/{name}", include_in_schema=False)
    def file(token: str, name: str) -> Response:
        try:
            content = _content(known(desk.daemon.store.path, token).folder, name)
        except RigError as error:
            return answer(from_error(error))
        headers = {"Cache-Control": "no-store", "X-Content-Type-Options": "nosniff"}
        return Response(content, media_type=TYPES[name], headers=headers)


def _content(folder: Path, name: str) -> bytes:
    path = folder / (CAMPAIGN if name == f"{CAMPAIGN}.zip" else name)
    if name not in TYPES or not path.exists():
        raise NotFoundError("no such file", part=name, todo="measure the film first")
    if path.is_file():
        return path.read_bytes()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for each in sorted(path.iterdir()):
            archive.write(each, f"{CAMPAIGN}/{each.name}")
    return packed.getvalue()
