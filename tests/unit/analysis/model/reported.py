"""Verdicts of a test's own making, read as other programs read them."""

from __future__ import annotations

from typing import Any

from analysis.schema.codec import read
from analysis.schema.verdict import VerdictReport

BARE: dict[str, Any] = {
    **{"campaign": "nylon", "shots": 20, "used": 20, "verdict": "none", "effects": []},
    **{"chi2_per_dof": 1.0, "p_chi2": 0.5, "path": [], "parameters": {}},
    "noise": {"position": 1.0, "orientation": 1.0},
}


def reported(**keys: object) -> VerdictReport:
    """Return a verdict with some keys of its document, all else as where nothing is missing."""
    whole = {**BARE, **keys}
    return read(VerdictReport, {"unexplained": whole["verdict"] == "unexplained", **whole})
