"""Next shots in words, and as a sweep."""

from __future__ import annotations

from rigctl.documents import Json
from rigctl.errors import NotFoundError
from rigctl.sweeps.form import Sweep


def sentence(document: Json) -> str:
    """Say in words what the next shots do."""
    count, even = document["shots"], document["even_shots"]
    shots = "1 shot" if count == 1 else f"{count} shots"
    spread = f"{even} spread evenly" if even is not None else "more than 5000 spread evenly"
    needed = f"{shots} (or {spread})" if count else "the campaign alone"
    short = "" if document["enough"] else ", less than was asked for"
    return f"{document['campaign']}: {needed} {_deed(document, plural=count > 1)}{short}."


def _deed(document: Json, *, plural: bool) -> str:
    if "sharpen" in document:
        verb = "bring" if plural else "brings"
        unit = "" if document["unit"] == "1" else f" {document['unit']}"
        return (
            f"{verb} the standard error of {document['sharpen']} from "
            f"{document['sigma_without']:.3g} to {document['sigma']:.3g}{unit}"
        )
    verb, (one, other) = "tell" if plural else "tells", document["between"]
    return (
        f"{verb} {one} from {other} with probability {document['probability']:.2f}, up from "
        f"{document['probability_without']:.2f}"
    )


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
