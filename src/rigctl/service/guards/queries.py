"""Parameters and headers of a request that stand once and are known, checked for all routes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_origin

from fastapi import Request
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from pydantic import BaseModel

from rigctl.service.guards.auth import ESTOP_PATH, PREFIX

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
