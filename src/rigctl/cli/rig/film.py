"""`rigctl film`: the word and the film of a camera that people work."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rigctl.cli.options import Config, Json, Key, KeyFile, given_key
from rigctl.cli.output import print_json, print_line
from rigctl.client import ServiceClient, connected
from rigctl.errors import AnalysisInputError, SettingsError

_WAITS = {
    "nothing": "no shot waits",
    "recording": "a shot waits: start the film, then `rigctl film --records`",
    "film": "a shot waits for its film: `rigctl film FILE`",
}


def film(
    path: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="The film: MP4, MOV, AVI, MKV, NPY.")
    ] = None,
    *,
    records: Annotated[
        bool, typer.Option("--records", help="The camera films now: the shot may fire.")
    ] = False,
    gives_up: Annotated[
        bool, typer.Option("--gives-up", help="There is no film: end the wait of the shot.")
    ] = False,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Say one thing of the camera, or bring its film; without either: what the shot waits for.

    Raises
    ------
    SettingsError
        More than one thing at once.
    AnalysisInputError
        There is no such file, or it is not the shot's film.
    RefusedError
        No shot waits for that.
    """
    if (path is not None) + records + gives_up > 1:
        raise SettingsError("are more than one thing", part="FILE, --records and --gives-up")
    if path is not None and not path.is_file():
        raise AnalysisInputError("no such file", part=str(path))
    with connected(config, given_key(key, key_file)) as daemon:
        if path is not None:
            _bring(daemon, path)
        if records or gives_up:
            daemon.film_word("records" if records else "gives-up")
        stands = daemon.film()
    if json:
        print_json(stands)
    else:
        print_line(_said(path, records=records, gives_up=gives_up) or _WAITS[stands["waits_for"]])


def _said(path: Path | None, *, records: bool, gives_up: bool) -> str:
    """Return what was brought about: what the shot waits for next may lie some way off."""
    if path is not None:
        return "the shot has its film"
    if records:
        return "the rig fires: end the film after the shot, then `rigctl film FILE`"
    return "the shot ends without a film" if gives_up else ""


def _bring(daemon: ServiceClient, path: Path) -> None:
    job = daemon.bring_film(path)
    if job["state"] != "done":
        raise AnalysisInputError(str(job["failure"]))
