"""Parameters and headers of a request that stand once and are known; bodies without a key twice."""

from __future__ import annotations

import json
from collections.abc import Callable, Coroutine, Iterator
from typing import Any, cast, get_origin

import anyio
from anyio import to_thread
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from pydantic import BaseModel, TypeAdapter, ValidationError
from starlette.requests import Request
from starlette.responses import Response

from rigctl.service.guards.auth import ESTOP_PATH, PREFIX


class DuplicateKeysError(ValueError):
    """Keys that stand more than once in an object of JSON; `values` holds theirs, in order."""

    def __init__(self, values: dict[str, list[Any]]) -> None:
        self.values = values
        super().__init__(f"keys that stand more than once: {', '.join(values)}")


class NotUtf8Error(ValueError):
    """JSON in another form than UTF-8, which is the only one of the interface (RFC 8259, 8.1)."""


def loads(text: bytes) -> object:
    """Return what a JSON text holds.

    Raises
    ------
    DuplicateKeysError
        An object has a key twice, so that its value is ambiguous.
    ValueError, RecursionError
        No JSON, not in UTF-8, or nested beyond all bounds.
    """
    if not json.detect_encoding(text).startswith("utf-8"):
        raise NotUtf8Error("not in UTF-8")
    content: object = json.loads(text, object_pairs_hook=_object)
    return content


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values: dict[str, list[Any]] = {}
    for key, value in pairs:
        values.setdefault(key, []).append(value)
    if twice := {key: given for key, given in values.items() if len(given) > 1}:
        raise DuplicateKeysError(twice)
    return dict(pairs)


LONG_BODY = 16_384
"""Bytes of a body that is read in a thread: the event loop, and with it a stop, goes on."""

MOST_FAULTS = 20
"""So many faults of a long body are named."""


class StrictRoute(APIRoute):
    """A route that refuses a body with a duplicate key; JSON readers take the last value."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Return the handler; a route that declares no body leaves it unread."""
        handle = super().get_route_handler()
        if self.body_field is None:
            return handle
        model: TypeAdapter[Any] = TypeAdapter(cast("Any", self.body_field.field_info.annotation))
        one_at_a_time = anyio.CapacityLimiter(1)

        async def checked(request: Request) -> Response:
            body = await request.body()
            if len(body) <= LONG_BODY:
                _require_single_keys(body)
            else:
                await to_thread.run_sync(_require_long, model, body, limiter=one_at_a_time)
            return await handle(request)

        return checked


def _require_long(model: TypeAdapter[Any], body: bytes) -> None:
    """Check a long body as the framework does; it reads the body again only if it is valid."""
    if (content := _require_single_keys(body)) is None:
        return
    try:
        model.validate_python(content)
    except ValidationError as error:
        faults = error.errors(include_url=False, include_context=True)[:MOST_FAULTS]
        within = [{**fault, "loc": ("body", *fault["loc"])} for fault in faults]
        raise RequestValidationError(within) from error


def _require_single_keys(body: bytes) -> object:
    """Return what a body holds; None where it is no JSON, which the framework will name."""
    try:
        return loads(body)
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
    except NotUtf8Error as error:
        shown = body[:20].decode("latin-1")
        fault = {"type": "not_utf8", "loc": ("body",), "msg": "is not JSON in UTF-8"}
        raise RequestValidationError([fault | {"input": shown}]) from error
    except (ValueError, RecursionError):
        return None


def _shown(key: str) -> str:
    """Return a key as UTF-8 can carry it: JSON can spell half a surrogate pair."""
    return key.encode(errors="backslashreplace").decode()


_SEVERAL = (list, tuple)
_ONCE = ("Idempotency-Key",)
"""Headers that may occur once: two of them would contradict each other."""


async def require_known(request: Request) -> None:
    """Refuse a query parameter that the OpenAPI document does not name, and one given twice.

    The emergency stop is never refused for its form, and paths outside the interface have clients
    with forms of their own.

    Raises
    ------
    RequestValidationError
        There is one; or a header occurs twice that may occur once.
    """
    path, route = request.url.path, request.scope.get("route")
    if not path.startswith(f"{PREFIX}/") or path == ESTOP_PATH or not isinstance(route, APIRoute):
        return
    faults = [*_headers(request), *_parameters(request, route)]
    if faults:
        raise RequestValidationError(faults)


def _parameters(request: Request, route: APIRoute) -> list[dict[str, Any]]:
    known = dict(_names(route))
    faults = []
    for name in dict.fromkeys(request.query_params.keys()):
        given = request.query_params.getlist(name)
        if name not in known:
            faults.append(_fault("query", name, "is no parameter of this path", given))
        elif len(given) > 1 and not known[name]:
            faults.append(_fault("query", name, f"stands {len(given)} times", given))
    return faults


def _names(route: APIRoute) -> Iterator[tuple[str, bool]]:
    """Give each query parameter of a route, or field of a model of them; and if it may repeat."""
    for parameter in route.dependant.query_params:
        form = parameter.field_info.annotation
        if isinstance(form, type) and issubclass(form, BaseModel):
            for name, about in form.model_fields.items():
                yield about.alias or name, get_origin(about.annotation) in _SEVERAL
        else:
            yield parameter.alias, get_origin(form) in _SEVERAL


def _headers(request: Request) -> list[dict[str, Any]]:
    return [
        _fault("header", name, f"stands {len(given)} times", given)
        for name in _ONCE
        if len(given := request.headers.getlist(name)) > 1
    ]


def _fault(place: str, name: str, what: str, given: list[str]) -> dict[str, Any]:
    return {"type": "not_once", "loc": (place, name), "msg": what, "input": given}
