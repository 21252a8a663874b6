"""Next shots in words, and as a sweep."""

from __future__ import annotations

from rigctl.documents import Json
from rigctl.errors import NotFoundError
from rigctl.sweeps.form import Sweep


def sentence(document: Json) -> str:
    """Say in words what the next shots do."""
    return f"{document['campaign']}: {_need(document)}.{_misfit(document)}"


def _need(document: Json) -> str:
    count, even = document["shots"], document["even_shots"]
    if count == 0:
        return f"no further shots are needed: the campaign alone {_deed(document, plural=False)}"
    shots = "1 shot" if count == 1 else f"{count} shots"
    spread = f"{even} spread evenly" if even is not None else "more than 5000 spread evenly"
    short = "" if document["enough"] else ", less than was asked for"
    return f"{shots} (or {spread}) {_deed(document, plural=count > 1)}{short}"


def _misfit(document: Json) -> str:
    """Say what a parameter's error does not hold where the model does not fit."""
    if document.get("fits", True):
        return ""
    first = document["add_first"]
    todo = "ask for the verdict" if first is None else f"add {first}"
    return (
        f" But the model does not fit (chi-squared is {document['chi2_per_dof']:.3g} per degree of "
        f"freedom, where 1 is the noise): {document['sharpen']} may be off by far more than its "
        f"error. First {todo}."
    )


def _deed(document: Json, *, plural: bool) -> str:
    if "sharpen" in document:
        unit = "" if document["unit"] == "1" else f" {document['unit']}"
        if document["shots"] == 0:
            return f"has a standard error of {document['sharpen']} of {document['sigma']:.3g}{unit}"
        verb = "bring" if plural else "brings"
        return (
            f"{verb} the standard error of {document['sharpen']} from "
            f"{document['sigma_without']:.3g} to {document['sigma']:.3g}{unit}"
        )
    verb, (one, other) = "tell" if plural else "tells", document["between"]
    before = f", up from {document['probability_without']:.2f}" if document["shots"] else ""
    return f"{verb} {one} from {other} with probability {document['probability']:.2f}{before}"


def sweep_of(document: Json) -> Sweep:
    """Return the next shots as a sweep, to be fired in a drawn order.

    Raises
    ------
    NotFoundError
        There is none to fire.
    """
    if not document["next_shots"]:
        raise NotFoundError(
            "no shots are needed", part="--out", todo="read the answer without --out"
        )
    if "sharpen" in document:
        note = f"sharpens {document['sharpen']} of {document['campaign']}"
    else:
        note = f"tells {' from '.join(document['between'])} after {document['campaign']}"
    return Sweep.model_validate({"note": note, "shots": document["next_shots"]})
