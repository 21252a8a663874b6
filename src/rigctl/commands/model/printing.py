"""What the commands of the model print alike."""

from __future__ import annotations

import json
import math
from typing import Any

from analysis.model.account import Accounted

Json = dict[str, Any]

TABLE_WIDTH = 110


def headline(title: str, found: Accounted) -> str:
    """Say what was fitted, how well, and what was left out."""
    fit = found.fit
    shots = len(fit.shot_chi2)
    first = (
        f"{title}: {shots} shots, chi-squared per degree of freedom {fit.chi2_per_dof:.4f} "
        f"(sampling error {math.sqrt(2 / max(fit.freedom, 1)):.4f})"
    )
    return "\n".join([first, *found.account.remarks()])


def print_json(document: Json) -> None:
    """Print one document on standard output."""
    print(json.dumps(document, allow_nan=False))  # noqa: T201
