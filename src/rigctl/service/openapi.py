"""The OpenAPI document: complete, with this rig's own limits and the models of all answers."""

from __future__ import annotations

import copy
import functools
import json
from collections.abc import Callable
from typing import Any

from fastapi import APIRouter, FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import TypeAdapter
from starlette.responses import Response

from analysis.schema.agreement import AgreementReport, StructureReport
from analysis.schema.shot import MeasuredResult, RefusedResult
from analysis.schema.verdict import FitReport, RankedCandidate, VerdictReport
from rigctl.access.scopes import ESTOP_PATH, PREFIX, ROUTES, Scope
from rigctl.config import Limits
from rigctl.documents import Json
from rigctl.service.problems import Problem, documented


def describe(app: FastAPI, limits: Limits) -> Callable[[], dict[str, Any]]:
    """Return the function that gives the document; it is built at the first call."""

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = _document(app, limits)
        return app.openapi_schema

    return openapi


def openapi_route(app: FastAPI) -> APIRouter:
    """Return the route of the document; it is packed once, or each reader would hold all up."""
    router = APIRouter()

    @functools.cache
    def packed() -> bytes:
        return json.dumps(app.openapi(), separators=(",", ":")).encode()

    @router.get("/openapi.json", include_in_schema=False)
    def openapi() -> Response:
        return Response(packed(), media_type="application/json")

    return router


def _document(app: FastAPI, limits: Limits) -> dict[str, Any]:
    document = get_openapi(
        title=app.title, version=app.version, description=app.description, routes=app.routes
    )
    components = document.setdefault("components", {})
    schemas = components.setdefault("schemas", {})
    problem = Problem.model_json_schema(
        mode="serialization", ref_template="#/components/schemas/{model}"
    )
    schemas.update(problem.pop("$defs", {}))
    schemas["Problem"] = problem
    schemas.update(report_schemas())
    components["securitySchemes"] = {
        "key": {
            "type": "http",
            "scheme": "bearer",
            "description": f"a key; {' '.join(str(Scope.__doc__).split())}",
        }
    }
    for path, operations in document["paths"].items():
        locked = path.startswith(f"{PREFIX}/") and path != ESTOP_PATH
        for method, operation in operations.items():
            operation["security"] = []
            if locked:
                _require_scope(operation, ROUTES[method.upper(), path.removeprefix(PREFIX)])
                # Whatever a path takes, a parameter that it does not take is refused.
                operation["responses"].setdefault("422", documented(422)[422])
            # What lies around all routes answers for them: foreign sites, bodies that do not come.
            for status in (403, 408) if "413" in operation["responses"] else (403,):
                operation["responses"].setdefault(str(status), documented(status)[status])
    schemas["ArmOrder"] = _narrowed(schemas["ShotSettings"], limits)
    body = document["paths"][f"{PREFIX}/rig/arm"]["post"]["requestBody"]
    body["content"]["application/json"]["schema"] = {"$ref": "#/components/schemas/ArmOrder"}
    return document


def _require_scope(operation: dict[str, Any], scope: Scope) -> None:
    """Add to a route the scope that it needs, and the refusal of a key without it."""
    operation["security"] = [{"key": [str(scope)]}]
    operation["x-scope"] = str(scope)
    if scope is not Scope.READ:
        # Every key may read.
        operation["responses"] |= {str(s): about for s, about in documented(403).items()}


def _narrowed(settings: dict[str, Any], limits: Limits) -> dict[str, Any]:
    """Return the schema of settings with this rig's limits in the place of those of physics.

    Only orders are narrowed: shots may have been fired under other limits.
    """
    order = copy.deepcopy(settings) | {"title": "ArmOrder"}
    fields = order["properties"]
    ranges = {
        "pressure_a_kpa": limits.pressure_kpa,
        "pressure_b_kpa": limits.pressure_kpa,
        "offset_mm": limits.offset_mm,
        "delay_us": limits.delay_us,
    }
    for field, (lowest, highest) in ranges.items():
        fields[field] |= {"minimum": lowest, "maximum": highest}
    for field in ("angle_a_deg", "angle_b_deg"):
        if limits.angle_deg is None:
            del fields[field]
        else:
            lowest, highest = limits.angle_deg
            fields[field] = {"type": "number", "minimum": lowest, "maximum": highest}
            order["required"] = [*order["required"], field]
    return order


REFERENCE = "#/components/schemas/{model}"
REPORTS = (AgreementReport, FitReport, RankedCandidate, StructureReport, VerdictReport)
RESULTS = (MeasuredResult, RefusedResult)
"""Of shots; each may leave a key out where it is None, which its reader takes for the same."""


def report_schemas() -> Json:
    """Return the JSON schemas of all reports and of their parts, by name."""
    schemas: Json = {}
    for kind in (*REPORTS, *RESULTS):
        schema = TypeAdapter(kind).json_schema(
            mode="validation" if kind in RESULTS else "serialization", ref_template=REFERENCE
        )
        schemas |= schema.pop("$defs", {})
        schemas[kind.__name__] = schema
    return schemas


def reported(
    *kinds: type, parts: dict[str, type] | None = None, lists: dict[str, type] | None = None
) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI entry of an answer that holds the keys of all these reports.

    Parameters
    ----------
    kinds
        Models whose keys are those of the answer.
    parts, lists
        Further keys, of which each holds a report, or a list of them.
    """
    further: Json = {key: _reference(kind) for key, kind in (parts or {}).items()}
    further |= {
        key: {"type": "array", "items": _reference(kind)} for key, kind in (lists or {}).items()
    }
    schema: Json = {"allOf": [_reference(kind) for kind in kinds]}
    if further:
        schema["allOf"].append(
            {"type": "object", "properties": further, "required": sorted(further)}
        )
    return {
        200: {
            "description": "The answer, for the shots as they are measured now",
            "content": {"application/json": {"schema": schema}},
        }
    }


def _reference(kind: type) -> dict[str, str]:
    return {"$ref": REFERENCE.format(model=kind.__name__)}
