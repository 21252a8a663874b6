"""What all requests and answers of the service have in common."""

from __future__ import annotations

from typing import Any, Self

from pydantic import BaseModel, ConfigDict


class Query(BaseModel):
    """The query of a request: text becomes numbers, unknown fields are refused."""

    model_config = ConfigDict(extra="forbid")


class View(BaseModel):
    """Part of an answer. Times are UTC; what is not known is null."""

    @classmethod
    def showing(cls, record: object, **others: object) -> Self:
        """Return a view of a record: its fields by their names, and those that are given."""
        fields: dict[str, Any] = {
            name: getattr(record, name) for name in cls.model_fields if name not in others
        }
        return cls(**fields, **others)
