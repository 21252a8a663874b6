"""What was proposed, in sentences that a command prints and the page shows."""

from __future__ import annotations

from typing import Any

from analysis.model.proposals.arguments import is_setting_name

Json = dict[str, Any]

MUCH_LEFT = 1.03
"""Error on shots left out, in units of the noise, beyond which laws that are named are not all."""


def proposal_sentences(document: Json) -> list[str]:
    """Return the sentences of a document of `rigctl model propose`."""
    found = [_headline(document)]
    found += [sentence for one in document["proposals"] for sentence in _of_one(one)]
    if document["proposals"]:
        found += _what_is_left(document)
        found.append(
            "A form that was chosen on these shots is confirmed on others: fire the next shots, "
            "and ask them alone with --confirm."
        )
    return [*found, *_bad_input(document)]


def _headline(document: Json) -> str:
    said = f"{document['campaign']}, {document['used']} shots"
    beside = f" beside {', '.join(document['with'])}" if document["with"] else ""
    if document["proposals"]:
        count = len(document["proposals"])
        return f"{said}: {'a law is' if count == 1 else f'{count} laws are'} proposed{beside}."
    if document["verdict"] == "effect":
        return f"{said}: {', '.join(document['with'])} explains it; no new law is needed."
    return f"{said}: no law is proposed{beside}; these shots ask for none."


def _what_is_left(document: Json) -> list[str]:
    """Say where the laws that are named leave much: their shape is near the true one, not it."""
    left = document["path"][-1]["prediction_error"]
    if left < MUCH_LEFT:
        return []
    return [
        f"With all of this the error is still {left:.4f} of the noise: what is named is not all, "
        "or its shape is none of those that are tried."
    ]


def _of_one(one: Json) -> list[str]:
    values = ", ".join(_value(name, quantity) for name, quantity in one["parameters"].items())
    what = f"{one['slot']} depends on {one['argument']}"
    found = [
        f"{what}: {one['formula']}, {values}; the error on shots left out falls from "
        f"{one['error_before']:.4f} to {one['error_after']:.4f} of the noise; chance "
        f"{one['p_familywise']:.2g} with all forms looked at."
    ]
    if len(one["shapes"]) > 1:
        found.append(f"  its shape may be any of {', '.join(one['shapes'])}.")
    alike = [f"{each['slot']} on {each['argument']}" for each in one["alike"]]
    if alike or one["alike_effects"]:
        others = ", ".join([*alike, *one["alike_effects"]])
        found.append(f"  these shots do not tell it from {others}.")
    if one["slot"] != "launch" and is_setting_name(one["argument"]):
        found.append(
            f"  {one['argument']} is set by the rig and acts through how the spheres meet: this "
            "stands for something of speeds and places that no form here is."
        )
    if one["hint"]:
        found.append(f"  {one['hint']}.")
    return found


def _value(name: str, quantity: Json) -> str:
    unit = "" if quantity["unit"] == "1" else f" {quantity['unit']}"
    return f"{name} = {quantity['value']:.4g} +- {quantity['sigma']:.2g}{unit}"


def _bad_input(document: Json) -> list[str]:
    left = [
        f"{one['argument']} takes no part: {one['reason']}; {one['todo']}."
        for one in document["left_out"]
    ]
    return left + [
        f"{' and '.join(one['arguments'])} run together here (correlation of ranks "
        f"{one['correlation']:.3f}); {one['todo']}."
        for one in document["confounded"]
    ]


def confirmation_sentence(document: Json) -> str:
    """Return the sentence of a document of `rigctl model propose --confirm`."""
    values = ", ".join(_value(name, own) for name, own in document["parameters"].items())
    word = "confirmed" if document["confirmed"] else "not confirmed"
    return (
        f"{document['campaign']}, {document['used']} shots that the form has not seen: "
        f"{document['effect']} is {word}, p = {document['p_value']:.2g}; {values}; error on shots "
        f"left out {document['error_before']:.4f} without it, {document['error_after']:.4f} with it"
    )


DIFFERENT = 0.01
"""Chance below which campaigns are said not to share an amplitude."""


def together_sentences(document: Json) -> list[str]:
    """Return the sentences of a document of several campaigns."""
    names = ", ".join(document["campaigns"])
    if not document["shared"]:
        return [f"{names}: together they ask for no law."]
    return [f"{names}: together they ask for", *map(_shared, document["shared"])]


def _shared(one: Json) -> str:
    each = ", ".join(
        f"{own['campaign']} not told"
        if own["amplitude"] is None
        else f"{own['campaign']} {own['amplitude']:.3g} +- {own['sigma']:.2g}"
        for own in one["each"]
    )
    word = "each its own" if one["p_alike"] < DIFFERENT else "one for all"
    return (
        f"  {one['slot']} against {one['argument']}, {one['shape']}: {one['amplitude']:.3g} +- "
        f"{one['sigma']:.2g}, chance {one['p_familywise']:.2g}; {word} (chance of such "
        f"differences {one['p_alike']:.2g}): {each}"
    )
