"""What the model and the analysis answer, in the OpenAPI document: the models of their schema."""

from __future__ import annotations

from typing import Any

from pydantic import TypeAdapter

from analysis.schema.agreement import AgreementReport, StructureReport
from analysis.schema.shot import MeasuredResult, RefusedResult
from analysis.schema.verdict import FitReport, RankedCandidate, VerdictReport
from rigctl.documents import Json

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
