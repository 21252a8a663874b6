"""The law in an answer to a challenge: its names are checked, as no answer is taken back."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import get_args

from analysis.exchange.shot_list import read_shot_list
from analysis.model.proposals.arguments import OF_PLACES, OF_SPINS, ON_BODIES, ORDER, SPEEDS
from analysis.model.proposals.channels import InFrames
from analysis.model.proposals.forms.flight import flight_forms
from analysis.model.proposals.forms.frame import frame_forms
from analysis.model.proposals.forms.shapes import SHAPES
from analysis.model.proposals.stated import Slot
from rigctl.challenge import Law
from rigctl.errors import SettingsError
from rigctl.input_errors import as_analysis_errors

SHOTS = "shots.csv"
_ANY_RADIUS_M, _ANY_MASS_KG = 0.0125, 0.01
"""Names of forms do not depend on the spheres."""


def known_law(folder: Path, law: Law) -> Law:
    """Return a law whose names are all known, the arguments of a product in alphabetical order.

    Parameters
    ----------
    folder
        Of the challenge: a law may follow the numeric columns of its shot list.

    Raises
    ------
    SettingsError
        A slot, an argument or a shape has no such name.
    AnalysisInputError
        The shot list cannot be read.
    """
    slot, argument, shape = law
    in_frames: list[InFrames] = [*flight_forms(_ANY_RADIUS_M, _ANY_MASS_KG), *frame_forms()]
    _require("slot", slot, get_args(Slot))
    arguments = {a.name for a in (*SPEEDS, *OF_SPINS, *OF_PLACES, *ON_BODIES)} | {ORDER}
    arguments |= {form.argument for form in in_frames} | _columns(folder)
    parts = sorted(argument.split("*"))
    for part in parts:
        _require("argument", part, arguments)
    _require("shape", shape, {s.name for s in SHAPES} | {f.shape_name for f in in_frames})
    return slot, "*".join(parts), shape


def _require(what: str, name: str, known: Iterable[str]) -> None:
    if name not in known:
        raise SettingsError(
            f"no {what} of a law has this name",
            part="--law",
            value=repr(name),
            todo=f"choose one of {', '.join(sorted(known))}",
        )


def _columns(folder: Path) -> set[str]:
    """Return the numeric columns of a challenge's shot list; none where there is no list."""
    path = folder / SHOTS
    if not path.is_file():
        return set()
    with as_analysis_errors("restore the challenge's folder, or make the challenge again"):
        return {name for row in read_shot_list(path) for name in row.numbers}
