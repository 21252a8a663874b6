"""Every error as an RFC 9457 problem document with a stable code."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, ConfigDict, Field, computed_field
from starlette.responses import Response

from rigctl.config import Limits
from rigctl.errors import (
    AnalysisInputError,
    ArmTokenError,
    DeviceError,
    FramesError,
    IdempotencyError,
    InterlockError,
    JobsFullError,
    KeyReusedError,
    NotFoundError,
    RecordingNotConfirmedError,
    RefusedError,
    RigError,
    SettingsError,
    StoreError,
    StreamsFullError,
)
from rigctl.rig.bounds import OUTSIDE, allowed

MEDIA_TYPE = "application/problem+json"

_STATUS: Mapping[type[RigError], tuple[int, str]] = {
    RigError: (500, "The rig failed"),
    SettingsError: (422, "A setting lies outside its limits"),
    RefusedError: (409, "The rig refuses"),
    InterlockError: (409, "Interlocks refuse"),
    ArmTokenError: (409, "The arm token does not hold"),
    IdempotencyError: (409, "The shot of this key is still under way"),
    KeyReusedError: (422, "The key was used with another body"),
    JobsFullError: (409, "Too many jobs wait"),
    NotFoundError: (404, "Nothing of that name is stored"),
    AnalysisInputError: (422, "What is to be analysed cannot be used"),
    DeviceError: (503, "A device failed"),
    RecordingNotConfirmedError: (503, "The camera does not record"),
    FramesError: (500, "The stored frames cannot be used"),
    StoreError: (503, "The store failed"),
    StreamsFullError: (503, "Too many event streams"),
}

_BOUNDS = {
    "ge": "at least {}",
    "gt": "more than {}",
    "le": "at most {}",
    "lt": "less than {}",
    "min_length": "a length of at least {}",
    "max_length": "a length of at most {}",
    "pattern": "text like {}",
    "expected": "{}",
}

_LONGEST_VALUE = 80


class FieldProblem(BaseModel):
    """One field of a request that cannot be, with what was found and what is allowed."""

    model_config = ConfigDict(extra="forbid")

    field: str
    detail: str
    value: str | None = None
    limit: str | None = None


class Problem(BaseModel):
    """Problem document: `code` is stable, `detail` is one sentence, `todo` the next step."""

    model_config = ConfigDict(extra="forbid")

    title: str
    status: int = Field(ge=400, le=599)
    detail: str
    code: str
    field: str | None = Field(default=None, description="field, device or file it happened to")
    value: str | None = Field(default=None, description="what was found, with its unit")
    limit: str | None = Field(default=None, description="what is allowed, with its unit")
    todo: str | None = Field(default=None, description="what to do next")
    shot: str | None = None
    interlocks: list[str] | None = Field(
        default=None, description="every interlock that refuses, one sentence each"
    )
    errors: list[FieldProblem] | None = Field(
        default=None, description="every field of the request that cannot be"
    )

    @computed_field(description="urn:rigctl: followed by the code")
    def type(self) -> str:
        """Return the name of this kind of problem as a URI."""
        return f"urn:rigctl:{self.code}"


def from_error(error: RigError) -> Problem:
    """Return the document of an error, with the status of the nearest listed class."""
    status, title = next(_STATUS[kind] for kind in type(error).__mro__ if kind in _STATUS)
    return Problem(
        status=status,
        code=error.code,
        title=title,
        detail=error.sentence(),
        field=error.part,
        value=error.value,
        limit=error.limit,
        todo=error.todo,
        shot=error.shot,
        interlocks=list(error.tripped) if isinstance(error, InterlockError) else None,
    )


def unforeseen(error: Exception, *, todo: str) -> Problem:
    """Return the document of an error that is none of ours: its kind, and nothing of its text."""
    return Problem(
        status=500,
        code="internal",
        title="The daemon failed",
        detail=f"an error that nobody foresaw: {type(error).__name__}",
        todo=todo,
    )


def from_validation(error: RequestValidationError, limits: Limits) -> Problem:
    """Return the document of a request that cannot be: 422, or 400 for its idempotency key.

    Of settings the limits of the rig are named, which are narrower than those of physics.
    """
    fields = [_field_problem(found, limits) for found in error.errors()]
    first = fields[0]
    if first.field == "Idempotency-Key":
        fault = "cannot be used" if first.value else "is missing"
        return Problem(
            status=400,
            code=IdempotencyError.code,
            title=f"The idempotency key {fault}",
            detail=f"{first.field}: {first.detail}",
            field=first.field,
            value=first.value,
            limit=first.limit,
            todo="send one fresh key of 1 to 200 visible characters with each new order",
        )
    return Problem(
        status=422,
        code="invalid-request",
        title="The request cannot be understood",
        detail="; ".join(f"{each.field}: {each.detail}" for each in fields),
        field=first.field,
        value=first.value,
        limit=first.limit,
        todo="correct the field and send the request again",
        errors=fields,
    )


def answer(document: Problem, headers: Mapping[str, str] | None = None) -> Response:
    """Return the HTTP answer that carries a problem document."""
    return Response(
        document.model_dump_json(exclude_none=True),
        status_code=document.status,
        media_type=MEDIA_TYPE,
        headers=headers,
    )


def documented(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI entries of the error answers a route can give."""
    schema = {"$ref": "#/components/schemas/Problem"}
    return {
        status: {"description": _MEANINGS[status], "content": {MEDIA_TYPE: {"schema": schema}}}
        for status in statuses
    }


_MEANINGS = {
    400: "The Idempotency-Key header is missing or malformed, or the body is not HTTP",
    401: "No key, or a wrong one",
    404: "Nothing of that name is stored",
    403: "The key lacks the scope that the route needs, or the request comes from another site",
    405: "The path knows no such method; Allow names those it knows",
    409: "The rig refuses (state, interlocks, arm token, a key whose shot is under way), or too "
    "many jobs wait",
    408: "The body did not come in time",
    411: "The body does not say how long it is",
    413: "The body is larger than any request of this service",
    422: "A field cannot be, or an idempotency key came with another body",
    500: "The daemon failed",
    503: "A device or the store failed",
}


def _field_problem(found: Mapping[str, Any], rig: Limits) -> FieldProblem:
    place: Sequence[str | int] = found["loc"]
    context = found.get("ctx", {})
    if found["type"] == "json_invalid":
        fault, position = str(context["error"]), int(place[1]) + 1
        detail = f"is not JSON: {fault[0].lower()}{fault[1:]} at character {position}"
        return FieldProblem(field=str(place[0]), detail=detail)
    inside = place[1:] if len(place) > 1 else place[:1]
    limits = [text.format(context[name]) for name, text in _BOUNDS.items() if name in context]
    missing = found["type"] == "missing"
    detail = found["msg"][0].lower() + found["msg"][1:]
    own = allowed(str(inside[-1]), rig)
    if own is not None and {"ge", "le"} & set(context):
        detail, limits = OUTSIDE, [own]
    return FieldProblem(
        field=".".join(str(step) for step in inside),
        detail=detail,
        value=None if missing else _shown(found.get("input")),
        limit=", ".join(limits) or None,
    )


def _shown(value: object) -> str:
    text = json.dumps(value, ensure_ascii=True, default=str)
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 3] + "..."
