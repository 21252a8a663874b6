"""The one way from a model to its JSON and back, for every model of a document."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypeVar

from pydantic import AliasChoices, ConfigDict, Field, TypeAdapter

Json = dict[str, Any]
Model = TypeVar("Model")
NotNegative = Annotated[float, Field(ge=0)]

SMALLEST_P = 1e-300
"""No chance is less than this in a document: some readers take a smaller number for none."""
STRICT = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, defer_build=True)
BESIDE = ConfigDict(strict=True, extra="ignore", allow_inf_nan=False, defer_build=True)
"""Of a model whose document may hold further keys, those of what else was asked."""


def named(key: str, field: str) -> Any:  # noqa: ANN401 - what a field is made of has no type
    """Return a field whose key in JSON is another than its name."""
    return Field(validation_alias=AliasChoices(key, field), serialization_alias=key)


def written(model: object, *, leave_out_none: bool = False) -> Json:
    """Return the JSON of a model, as plain objects."""
    document: Json = _adapter(type(model)).dump_python(
        model, mode="json", by_alias=True, exclude_none=leave_out_none
    )
    return document


def read(kind: type[Model], document: Mapping[str, Any]) -> Model:
    """Return the model that a document holds; arrays may be lists.

    Raises
    ------
    pydantic.ValidationError
        A key is unknown, missing, or out of its range.
    """
    model: Model = _adapter(kind).validate_json(json.dumps(document))
    return model


def read_all(kind: type[Model], documents: Sequence[Mapping[str, Any]]) -> list[Model]:
    """Return the models that a list holds; raises as `read`."""
    models: list[Model] = _adapter(list[kind]).validate_json(  # type: ignore[valid-type]
        json.dumps(documents)
    )
    return models


def written_all(kind: type[Model], models: Sequence[Model]) -> list[Json]:
    """Return the JSON of models of one kind, as plain objects."""
    documents: list[Json] = _adapter(list[kind]).dump_python(  # type: ignore[valid-type]
        models, mode="json", by_alias=True
    )
    return documents


_ADAPTERS: dict[object, TypeAdapter[Any]] = {}


def _adapter(kind: Any) -> TypeAdapter[Any]:  # noqa: ANN401 - classes of any kind
    if kind not in _ADAPTERS:
        _ADAPTERS[kind] = TypeAdapter(kind)
    return _ADAPTERS[kind]
