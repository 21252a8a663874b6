"""What the commands of the model print alike."""

from __future__ import annotations

import json
from typing import Any

Json = dict[str, Any]

TABLE_WIDTH = 110


def print_json(document: Json) -> None:
    """Print one document on standard output."""
    print(json.dumps(document, allow_nan=False))  # noqa: T201
