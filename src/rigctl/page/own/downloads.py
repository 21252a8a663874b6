"""What came of a film, as files that the browser fetches: figure, result, and campaign as ZIP."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path

from fastapi import FastAPI
from starlette.responses import Response

from rigctl.errors import NotFoundError, RigError
from rigctl.page.desk import Desk
from rigctl.page.own.brought import CAMPAIGN, FIGURE, MEASURED, RESULT, known
from rigctl.service.problems import answer, from_error

ADDRESS = "/own-data"
KINDS = (
    (re.compile(rf"{FIGURE}-[0-9]+\.png"), "image/png"),
    (re.compile(rf"{RESULT}-[0-9]+\.json"), "application/json"),
    (re.compile(rf"{CAMPAIGN}\.zip"), "application/zip"),
)


def downloads_route(app: FastAPI, desk: Desk) -> None:
    """Register the route, beside the pages; it gives nothing but the files of `KINDS`."""

    @app.get(ADDRESS + "/{token}/{name}", include_in_schema=False)
    def file(token: str, name: str) -> Response:
        try:
            made = known(desk.daemon.store.path, token).folder / MEASURED
            content, kind = _content(made, name)
        except RigError as error:
            return answer(from_error(error))
        headers = {"Cache-Control": "no-store", "X-Content-Type-Options": "nosniff"}
        return Response(content, media_type=kind, headers=headers)


def _content(folder: Path, name: str) -> tuple[bytes, str]:
    path = folder / (CAMPAIGN if name == f"{CAMPAIGN}.zip" else name)
    kind = next((kind for names, kind in KINDS if names.fullmatch(name)), None)
    if kind is None or not path.exists():
        raise NotFoundError("no such file", part=name, todo="measure the film first")
    if path.is_file():
        return path.read_bytes(), kind
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for each in sorted(path.iterdir()):
            archive.write(each, f"{CAMPAIGN}/{each.name}")
    return packed.getvalue(), kind
