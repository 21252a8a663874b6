"""Request bodies in which every key stands once."""

from __future__ import annotations

import json
from collections.abc import Callable, Coroutine
from typing import Any

from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from starlette.requests import Request
from starlette.responses import Response


class DuplicateKeysError(ValueError):
    """Keys that stand more than once in an object of JSON; `values` holds theirs, in order."""

    def __init__(self, values: dict[str, list[Any]]) -> None:
        self.values = values
        super().__init__(f"keys that stand more than once: {', '.join(values)}")


def loads(text: bytes) -> object:
    """Return what a JSON text holds.

    Raises
    ------
    DuplicateKeysError
        An object has a key twice: which of its values was meant, nobody can know.
    ValueError, RecursionError
        No JSON, not in UTF-8, or nested beyond all bounds.
    """
    content: object = json.loads(text, object_pairs_hook=_object)
    return content


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values: dict[str, list[Any]] = {}
    for key, value in pairs:
        values.setdefault(key, []).append(value)
    if twice := {key: given for key, given in values.items() if len(given) > 1}:
        raise DuplicateKeysError(twice)
    return dict(pairs)


class StrictRoute(APIRoute):
    """A route that refuses a body with a key that stands twice; JSON readers take the last."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler; a route that declares no body leaves it unread."""
        handle = super().get_route_handler()
        if self.body_field is None:
            return handle

        async def checked(request: Request) -> Response:
            _require_single_keys(await request.body())
            return await handle(request)

        return checked


def _require_single_keys(body: bytes) -> None:
    try:
        loads(body)
    except DuplicateKeysError as error:
        raise RequestValidationError(
            [
                {
                    "type": "duplicate_key",
                    "loc": ("body", _shown(key)),
                    "msg": f"stands {len(values)} times",
                    "input": values,
                }
                for key, values in error.values.items()
            ]
        ) from error
    except (ValueError, RecursionError):
        # The framework reads the body once more, and names what else is wrong with it.
        return


def _shown(key: str) -> str:
    """Return a key as UTF-8 can carry it: JSON can spell half a surrogate pair."""
    return key.encode(errors="backslashreplace").decode()
