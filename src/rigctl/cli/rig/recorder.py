"""`rigctl recorder`: the tape recorder's keypad."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import typer

from rigctl.cli.options import Config, Json, Key, KeyFile, given_key
from rigctl.cli.output import print_json, print_line
from rigctl.client import connected
from rigctl.errors import RefusedError

_KEYS = "live, record, stop, replay, play, jog, step, search, gamma, erase, when-full"


def recorder(
    pressed: Annotated[
        str, typer.Argument(metavar="[KEY]", help=f"One of {_KEYS}; without one: how it stands.")
    ] = "",
    *,
    speed: Annotated[
        int | None, typer.Option(help="jog: 1 to 30 pictures a second, negative for backwards.")
    ] = None,
    by: Annotated[int | None, typer.Option(help="step: 1 forward, -1 back.")] = None,
    session: Annotated[int | None, typer.Option(help="search: session on the tape.")] = None,
    mark: Annotated[
        int | None, typer.Option(help="search: event marker of the session, counted from 1.")
    ] = None,
    frame: Annotated[
        int | None, typer.Option(help="search: picture of the session, counted from 0.")
    ] = None,
    time_s: Annotated[
        float | None, typer.Option(help="search: time from the session's first picture, s.")
    ] = None,
    gamma: Annotated[
        float | None, typer.Option(help="gamma: exponent of the grey levels, 0.1 to 1.")
    ] = None,
    erase: Annotated[
        bool | None,
        typer.Option("--erase/--ask", help="when-full: shots may erase a full tape, or ask."),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="erase: without the question.")] = False,
    config: Config = None,
    key: Key = None,
    key_file: KeyFile = None,
    json: Json = False,
) -> None:
    """Press one key of the recorder and say how it stands then.

    Raises
    ------
    RefusedError
        A shot is under way, the recorder does not do that now, or the tape is not to be erased.
    SettingsError
        The key takes something else.
    """
    given = {
        "speed": speed, "by": by, "session": session, "mark": mark, "frame": frame,
        "time_s": time_s, "gamma": gamma, "erase": erase,
    }  # fmt: skip
    order = {name: value for name, value in given.items() if value is not None}
    with connected(config, given_key(key, key_file)) as daemon:
        if pressed == "erase" and not yes:
            _ask_first(daemon.recorder())
        stands = daemon.press({"key": pressed, **order}) if pressed else daemon.recorder()
    if json:
        print_json(stands)
    else:
        _print(stands)


def _ask_first(stands: Mapping[str, Any]) -> None:
    on_tape = sum(session["pictures"] for session in stands["sessions"])
    question = f"Erase {len(stands['sessions'])} sessions with {on_tape} pictures, for good?"
    if not typer.confirm(question):
        raise RefusedError("the tape is not erased", todo="erase it with --yes, or at the prompt")


def _print(stands: Mapping[str, Any]) -> None:
    print_line(
        f"{stands['mode']}: session {stands['session']} with {stands['pictures']} pictures, tape "
        f"{stands['place']} with {stands['seconds_left']:.1f} s left (a shot needs "
        f"{stands['needed_s']:.1f} s, then it is {_then(stands)})"
    )
    if stands["picture"] is not None:
        print_line(f"picture {stands['picture']}, {stands['picture_s']:.4f} s from the first")
    if stands["marks"]:
        pictures = "picture" if len(stands["marks"]) == 1 else "pictures"
        print_line(f"marked at {pictures} {', '.join(map(str, stands['marks']))}")
    for session in stands["sessions"]:
        print_line(f"  session {session['session']}: {session['pictures']} pictures")
    if stands["gamma"] is not None:
        print_line(f"gamma {stands['gamma']:.2f}")


def _then(stands: Mapping[str, Any]) -> str:
    return "erased" if stands["erases_when_full"] else "asked for"
