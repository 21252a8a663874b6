"""Bodies longer than any request of this service are refused, and those that come too slowly."""

from __future__ import annotations

import anyio
from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from rigctl.service.guards.auth import ESTOP_PATH, PREFIX
from rigctl.service.problems import Problem, answer

LONGEST_BODY = 16_384
"""Bytes; the longest request, an order with a note in escaped characters, has a third of it."""

LONGEST_SWEEP = 1_048_576
"""Bytes of an order for a sweep, which may list every one of its shots."""

BODY_WITHIN_S = 10.0
"""A body that has not come whole within this time is refused, s."""

SWEEPS_PATH = f"{PREFIX}/sweeps"

FILM_PATH = f"{PREFIX}/rig/film/"
"""Of a film that is brought for a shot: its route writes it to disk as it comes."""

LONGEST_FILM = 2 * 1024**3
"""Bytes of such a film."""


class BodyLimit:
    """Refuses a body that is too long, comes too slowly, or has no stated length.

    The emergency stop is let through: it reads no more of its body than it can use.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 408, 411 or 413, or pass the request on with its whole body."""
        if scope["type"] != "http" or scope["path"] == ESTOP_PATH:
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        film = scope["method"] == "PUT" and scope["path"].startswith(FILM_PATH)
        longest = LONGEST_SWEEP if scope["path"] == SWEEPS_PATH else LONGEST_BODY
        refusal = _refusal(headers, LONGEST_FILM if film else longest)
        if refusal is None and not film and headers.get("content-length", "0") != "0":
            try:
                with anyio.fail_after(BODY_WITHIN_S):
                    receive = await _whole(receive)
            except TimeoutError:
                refusal = _TOO_SLOW
        if refusal is None:
            await self._app(scope, receive, send)
        else:
            await answer(refusal)(scope, receive, send)


async def _whole(receive: Receive) -> Receive:
    """Read a body to its end, or the caller's; return what hands the same messages on."""
    messages = [await receive()]
    while messages[-1].get("more_body", False):
        messages.append(await receive())
    waiting = iter(messages)

    async def again() -> Message:
        message = next(waiting, None)
        return await receive() if message is None else message

    return again


_TOO_SLOW = Problem(
    status=408,
    code="body-too-slow",
    title="The body did not come in time",
    detail=f"the body was not whole within {BODY_WITHIN_S:g} s",
    limit=f"{BODY_WITHIN_S:g} s",
    todo="send the request again, over a better line",
)


def _refusal(headers: Headers, longest: int) -> Problem | None:
    if "transfer-encoding" in headers:
        return Problem(
            status=411,
            code="length-required",
            title="The body does not say how long it is",
            detail="the request has a body without Content-Length",
            field="Content-Length",
            todo="send the body in one piece with its length",
        )
    length = headers.get("content-length", "0")
    # Digits only: the server below has refused any other form of the header already.
    if length.isdecimal() and int(length) <= longest:
        return None
    return Problem(
        status=413,
        code="body-too-large",
        title="The body is too long",
        detail=f"a body of {length} bytes; {longest} are allowed",
        field="Content-Length",
        value=f"{length} bytes",
        limit=f"{longest} bytes",
        todo="send less",
    )
