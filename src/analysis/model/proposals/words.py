"""What was proposed, in sentences that a command prints and the page shows."""

from __future__ import annotations

from typing import Any

import numpy as np

from analysis.model.proposals.arguments import is_setting_name
from analysis.quantity import Quantity

Json = dict[str, Any]

MUCH_LEFT = 1.03
"""Error on shots left out, in units of the noise, beyond which laws that are named are not all."""
DIFFERENT = 0.01
"""Chance below which campaigns are said not to share an amplitude."""
SMALLEST_CHANCE = 1e-12
"""Below it a chance is said to be less than this: no experiment knows its noise so well."""
_PLAIN = -4, 6
"""Powers of ten between which a number is written without one."""
_MEANINGS = {
    "e": "the coefficient of restitution",
    "mu": "the coefficient of friction",
    "beta0": "the rolling coefficient of restitution",
    "torsion": "the torque about the normal",
    "impulse_n": "the impulse along the normal",
    "impulse_t": "the impulse across the normal",
    "flight": "a force in flight",
    "camera": "an error of the camera",
    "clock": "an error of the frame times",
    "launch": "how the spheres leave their tubes",
    "speed_n": "the normal speed of approach v_n",
    "speed_s": "the sliding speed v_s",
    "obliquity": "v_s/v_n",
    "spin": "the relative spin about the normal w_n",
    "normal": "the direction of the normal in the room",
    "contact_x": "the place of the contact, X down",
    "contact_y": "the place of the contact, Y to the right",
    "contact_z": "the place of the contact, Z toward the camera",
    "place_a": "the place of the contact on the body of a",
    "place_b": "the place of the contact on the body of b",
    "order": "the order of firing, -0.5 for the first shot to 0.5 for the last",
    "distance": "the distance of the centres",
    "velocity": "the velocity",
    "uniform": "nothing: it is the same everywhere",
    "time": "the time since the first frame",
}
"""Of names that a reader may not know."""


def proposal_sentences(document: Json) -> list[str]:
    """Return the sentences of a document of `rigctl model propose`."""
    found = [_headline(document)]
    found += [sentence for one in document["proposals"] for sentence in _of_one(one)]
    found += _what_is_left(document)
    if document["proposals"]:
        found.append(
            "A law that was chosen to suit these shots suits them too well. Test it on new ones: "
            "fire the next shots, then ask with --confirm."
        )
    return [*found, *_bad_input(document)]


def _headline(document: Json) -> str:
    said = f"{document['campaign']}, {document['used']} shots"
    known = ", ".join(document["with"])
    beside = f", beside the known {known}" if known else ""
    if document["proposals"]:
        count = len(document["proposals"])
        return f"{said}: {'a law is' if count == 1 else f'{count} laws are'} proposed{beside}."
    if document["verdict"] == "effect":
        return f"{said}: {known} of the catalogue is what is missing; no new law is needed."
    return f"{said}: no law is proposed{beside}."


def _what_is_left(document: Json) -> list[str]:
    """Say where the laws that are named leave much: their shape is near the true one, not it."""
    left = document["path"][-1]["prediction_error"]
    if left < MUCH_LEFT:
        return []
    if not document["proposals"]:
        return [
            f"The error on shots left out is {left:.3f}, and 1 is noise alone: something is "
            "missing, and it is none of the forms that are tried."
        ]
    return [
        f"With all of this the error is still {left:.3f}, and 1 is noise alone: what is named is "
        "not all, or its shape is none of those that are tried."
    ]


def _of_one(one: Json) -> list[str]:
    values = ", ".join(_value(name, quantity) for name, quantity in one["parameters"].items())
    found = [
        f"{_explained(one['slot'])} depends on {_explained(one['argument'])}:",
        f"  {one['formula']}",
        f"  with {values}",
        f"  error on shots left out: {one['error_before']:.4f} without this law, "
        f"{one['error_after']:.4f} with it (1 is noise alone)",
        f"  chance that noise alone looks like this in some form: {_chance(one['p_familywise'])}",
    ]
    if len(one["shapes"]) > 1:
        found.append(f"  other shapes fit nearly as well: {', '.join(one['shapes'][1:])}")
    alike = [f"{each['slot']} on {each['argument']}" for each in one["alike"]]
    if alike or one["alike_effects"]:
        others = ", ".join([*alike, *one["alike_effects"]])
        found.append(f"  these shots cannot tell it from: {others}")
    outside = [part for part in one["argument"].split("*") if _is_not_set_by_the_rig(part)]
    if outside and one["next_shots"]:
        found.append(
            f"  its next shots do not change {' and '.join(outside)}: fire them over values as far "
            "apart as in these shots"
        )
    if one["slot"] != "launch" and is_setting_name(one["argument"]):
        found.append(
            f"  {one['argument']} is set by the rig and acts through how the spheres meet: this "
            "stands for something of speeds and places that no form here is"
        )
    if one["hint"]:
        found.append(f"  {one['hint']}")
    return found


def _is_not_set_by_the_rig(argument: str) -> bool:
    """Whether an argument is a column of the shot list that the rig does not set."""
    return argument not in _MEANINGS and not is_setting_name(argument)


def _explained(name: str) -> str:
    """Return a name and what it is; of a product both."""
    if "*" in name:
        return " times ".join(_explained(part) for part in name.split("*"))
    return f"{name} ({_MEANINGS[name]})" if name in _MEANINGS else name


def _value(name: str, quantity: Json) -> str:
    """Return `a = 0.00049 +- 0.00006 K^-1`: as many digits as the error has two of."""
    unit = "" if quantity["unit"] == "1" else f" {quantity['unit']}"
    known = Quantity.from_json(quantity)
    value, sigma = known.value, known.sigma
    if not np.isfinite(sigma) or sigma <= 0.0:
        return f"{name} = {value:.4g}{unit}"
    last = int(np.floor(np.log10(sigma))) - 1
    size = int(np.floor(np.log10(max(abs(value), sigma))))
    if _PLAIN[0] <= size < _PLAIN[1]:
        digits = max(-last, 0)
        return f"{name} = {value:.{digits}f} +- {sigma:.{digits}f}{unit}"
    digits, scale = max(size - last, 0), 10.0**size
    numbers = f"{value / scale:.{digits}f} +- {sigma / scale:.{digits}f}"
    return f"{name} = ({numbers}) x 10^{size}{unit}"


def _chance(p_value: float) -> str:
    return f"less than {SMALLEST_CHANCE:g}" if p_value < SMALLEST_CHANCE else f"{p_value:.2g}"


def _bad_input(document: Json) -> list[str]:
    left = [
        f"{one['argument']} is not tested: {one['reason']}. To test it, {one['todo']}."
        for one in document["left_out"]
    ]
    return left + [
        f"{' and '.join(one['arguments'])} change together here (rank correlation "
        f"{one['correlation']:.3f}). To tell them apart, {one['todo']}."
        for one in document["confounded"]
    ]


def confirmation_sentence(document: Json) -> str:
    """Return the sentence of a document of `rigctl model propose --confirm`."""
    values = ", ".join(_value(name, own) for name, own in document["parameters"].items())
    word = "confirmed" if document["confirmed"] else "not confirmed"
    beside = f", beside {', '.join(document['with'])}" if document["with"] else ""
    return (
        f"{document['campaign']}: {document['effect']} is {word} by {document['used']} shots on "
        f"which it was not chosen{beside}: chance {_chance(document['p_value'])} where it is not "
        f"there; {values}; error on shots left out {document['error_before']:.4f} without it, "
        f"{document['error_after']:.4f} with it (1 is noise alone)."
    )


def together_sentences(document: Json) -> list[str]:
    """Return the sentences of a document of several campaigns."""
    names = ", ".join(document["campaigns"])
    known = [
        f"{one['campaign']}: with {', '.join(one['effects'])} in its fit."
        for one in document["with"]
        if one["effects"]
    ]
    if not document["shared"]:
        return [f"{names}: together they ask for no law.", *known]
    return [f"{names}: together they ask for", *map(_shared, document["shared"]), *known]


def _shared(one: Json) -> str:
    each = ", ".join(
        f"{own['campaign']} cannot see it"
        if own["amplitude"] is None
        else f"{own['campaign']} {own['amplitude']:.3g} +- {own['sigma']:.2g}"
        for own in one["each"]
    )
    return (
        f"  {one['slot']} against {one['argument']}, {one['shape']}: amplitude "
        f"{one['amplitude']:.3g} +- {one['sigma']:.2g}; chance that noise alone looks like this "
        f"{_chance(one['p_familywise'])}; {_compared(one)}: {each}"
    )


def _compared(one: Json) -> str:
    """Say whether campaigns share an amplitude, where two or more of them see it."""
    if sum(own["amplitude"] is not None for own in one["each"]) < 2:
        return "one campaign alone can see it, so that nothing is said to be shared"
    word = "each its own" if one["p_alike"] < DIFFERENT else "the same in all that see it"
    return f"{word} (chance of such differences where they share one {_chance(one['p_alike'])})"
