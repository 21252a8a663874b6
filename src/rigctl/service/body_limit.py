"""Bodies longer than any request of this service are refused before they are read."""

from __future__ import annotations

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from rigctl.service.auth import ESTOP_PATH, PREFIX
from rigctl.service.problems import Problem, answer

LONGEST_BODY = 16_384
"""Bytes; the longest request, an order with a note in escaped characters, has a third of it."""

LONGEST_SWEEP = 1_048_576
"""Bytes of an order for a sweep, which may list every one of its shots."""

SWEEPS_PATH = f"{PREFIX}/sweeps"


class BodyLimit:
    """Refuses a body that is too long, and one that does not say how long it is.

    The emergency stop is let through: it reads no more of its body than it can use.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer 411 or 413, or pass the request on."""
        refusal = None
        if scope["type"] == "http" and scope["path"] != ESTOP_PATH:
            longest = LONGEST_SWEEP if scope["path"] == SWEEPS_PATH else LONGEST_BODY
            refusal = _refusal(Headers(scope=scope), longest)
        if refusal is None:
            await self._app(scope, receive, send)
        else:
            await answer(refusal)(scope, receive, send)


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
