"""What was proposed, as other programs read it, with the nearest known physics in words.

Those are a hint, never a finding: what depends on what, in which direction, and where the
literature has met it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.model.design.between import Repeated
from analysis.model.design.document import shots_document
from analysis.model.fitting.adding import ALIAS_WITHIN
from analysis.model.proposals.channels import Form
from analysis.model.proposals.confirm import Confirmation
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.forms.launch import LaunchForm
from analysis.model.proposals.forms.shapes import POWER
from analysis.model.proposals.launch_search import LaunchProposal
from analysis.model.proposals.proposed import Accepted, Proposed
from analysis.model.proposals.screen import SMALLEST_P
from analysis.model.proposals.stated import Origin, Statement
from analysis.model.proposals.together import Together
from analysis.model.proposals.wording import formula, latex


@dataclass(frozen=True, slots=True)
class Hint:
    """A known cause.

    Attributes
    ----------
    slot, argument
        What depends on what; an argument that ends in `*` means every name that begins so.
    rising
        Whether the coefficient rises with the argument; None: either.
    shapes
        The shapes it has; none: any.
    cause, source
        In words, and where it is described.
    """

    slot: str
    argument: str
    rising: bool | None
    shapes: tuple[str, ...]
    cause: str
    source: str


HINTS = (
    Hint(
        "e",
        "temperature*",
        False,
        (),
        "viscous loss that grows toward a glass transition",
        "J. D. Ferry, Viscoelastic Properties of Polymers (1980)",
    ),
    Hint(
        "e",
        "temperature*",
        True,
        (),
        "trapped gas or a polymer above its loss peak, which stiffens or loses less when warm",
        "R. Cross, Am. J. Phys. 79, 483 (2011)",
    ),
    Hint(
        "mu",
        "temperature*",
        None,
        (),
        "shear strength of a polymer surface that follows its temperature",
        "B. J. Briscoe and D. Tabor, J. Adhes. 9, 145 (1978)",
    ),
    Hint(
        "mu",
        "spin",
        False,
        (),
        "spin about the normal takes up part of the friction: Contensou's effect",
        "P. Contensou, in Kreiselprobleme (1963), 201",
    ),
    Hint(
        "mu",
        "speed_s",
        False,
        ("exponential", "power", "bump"),
        "friction that falls with slip: Stribeck's curve, or an air or oil film that builds up",
        "R. Stribeck, Z. Ver. Dtsch. Ing. 46, 1341 (1902)",
    ),
    Hint(
        "mu",
        "speed_n",
        False,
        (),
        "friction that falls with the load, as a real area of contact that grows less than it",
        "J. F. Archard, Proc. R. Soc. A 243, 190 (1957)",
    ),
    Hint(
        "e",
        "speed_n",
        False,
        ("hinge", "power", "linear", "exponential", "step"),
        "loss that grows with speed: viscoelastic contact, or yield",
        "T. Schwager and T. Poeschel, Phys. Rev. E 78, 051304 (2008)",
    ),
    Hint(
        "e",
        "speed_n",
        None,
        ("bump", "periodic"),
        "vibration of a body or its support at a multiple of the contact's duration",
        "C. Zener, Phys. Rev. 59, 669 (1941)",
    ),
    Hint(
        "e",
        "obliquity",
        None,
        (),
        "asperities or a turning contact: restitution of oblique impacts",
        "M. Y. Louge and M. E. Adams, Phys. Rev. E 65, 021303 (2002)",
    ),
    Hint(
        "e",
        "normal",
        None,
        (),
        "a body or support that is not alike in all directions, or pixels that are not square",
        "W. J. Stronge, Impact Mechanics (2000)",
    ),
    Hint(
        "*",
        "humidity*",
        None,
        (),
        "water taken up by the surface: softer polyamide, capillary bridges",
        "B. Bhushan, Introduction to Tribology (2013)",
    ),
    Hint(
        "launch",
        "temperature*",
        None,
        (),
        "seals and grease of a pusher, whose friction follows the temperature",
        "ISO 6358-1 (2013) states flow at one temperature; friction of seals: B. N. J. Persson, J. "
        "Chem. Phys. 115, 3840 (2001)",
    ),
    Hint(
        "launch",
        "pressure*",
        None,
        (),
        "flow through the valve that chokes, or friction that grows with the pressure",
        "J. D. Anderson, Modern Compressible Flow (2003), chapter 5",
    ),
    Hint(
        "*",
        "order",
        None,
        (),
        "wear, warming or cleaning in the course of the campaign; a step: something was touched",
        "J. F. Archard, J. Appl. Phys. 24, 981 (1953)",
    ),
    Hint(
        "*",
        "place_*",
        None,
        (),
        "a body that is not alike all over: a seam, a marker, a void",
        "W. J. Stronge, Impact Mechanics (2000)",
    ),
    Hint(
        "*",
        "contact_*",
        None,
        (),
        "something fixed in the room: a draught, a lamp, or an image that errs with the place",
        "the field of view is the same for all shots: look at the camera first",
    ),
    Hint(
        "flight",
        "distance",
        None,
        ("power",),
        "a force between the spheres: charges give 1/d^2, dipoles 1/d^4",
        "J. D. Jackson, Classical Electrodynamics (1999), chapter 4",
    ),
    Hint(
        "flight",
        "distance",
        None,
        ("exponential",),
        "a force between the spheres that is screened, or air pressed out of the gap",
        "J. N. Israelachvili, Intermolecular and Surface Forces (2011)",
    ),
    Hint(
        "flight",
        "velocity",
        True,
        (),
        "drag of the air beyond what is stated",
        "L. Schiller and A. Naumann, Z. Ver. Dtsch. Ing. 77, 318 (1933)",
    ),
)


def hint_for(slot: str, argument: str, shape: str, *, rising: bool) -> str | None:
    """Return the nearest known physics in words, marked as a hint; None: nothing is known."""
    for hint in HINTS:
        if (
            _matches(hint.slot, slot)
            and _matches(hint.argument, argument)
            and (hint.rising is None or hint.rising == rising)
            and (not hint.shapes or shape in hint.shapes)
        ):
            return f"hint, not a finding: {hint.cause} ({hint.source})"
    return None


def _matches(pattern: str, name: str) -> bool:
    if pattern.endswith("*"):
        return name.startswith(pattern[:-1]) and "*" not in name
    return name == pattern


Json = dict[str, Any]


def proposals_document(
    campaign: str, proposed: Proposed, following: Sequence[Repeated] = ()
) -> Json:
    """Return the document of `rigctl model propose --json`."""
    origin = Origin.of(campaign, proposed)
    return {
        "campaign": campaign,
        "shots": len(proposed.evidence.stated.shots),
        "used": len(proposed.data.shots),
        "verdict": verdict(proposed),
        "with": list(proposed.effects),
        "path": [
            {
                "with": list(stage.effects),
                "chi2_per_dof": stage.fit.chi2_per_dof,
                "prediction_error": stage.error.value,
            }
            for stage in proposed.path
        ],
        "proposals": [
            _proposal(proposed, one, following if k == 0 else ()) | _stated(one.form, origin)
            for k, one in enumerate(proposed.accepted)
        ]
        + [
            _of_launch(proposed, one, following if not (proposed.accepted or k) else ())
            | _stated(one.form, origin)
            for k, one in enumerate(proposed.launch)
        ],
        "left_out": [
            {"argument": one.argument, "reason": one.reason, "todo": one.todo}
            for one in proposed.admitted.left_out
        ],
        "confounded": [
            {
                "arguments": list(one.arguments),
                "correlation": one.correlation,
                "todo": one.todo,
            }
            for one in proposed.admitted.confounded
        ],
    }


def _stated(form: Form | LaunchForm, origin: Origin) -> Json:
    """Return the form in full: what a test of it on other shots takes."""
    return {"form": Statement.of(form, origin).document()}


def verdict(proposed: Proposed) -> str:
    """Return `proposal`; else `effect`, where the catalogue holds what is missing, or `none`."""
    if proposed.accepted or proposed.launch:
        return "proposal"
    return "effect" if set(proposed.effects) - set(proposed.path[0].effects) else "none"


def _proposal(proposed: Proposed, one: Accepted, following: Sequence[Repeated]) -> Json:
    form = one.form
    return {
        "slot": form.slot,
        "argument": form.argument,
        "shape": form.shape_name,
        "name": one.name,
        "formula": formula(form),
        "latex": latex(form),
        "parameters": {name: q.to_json() for name, q in one.quantities.items()},
        "p_familywise": one.p_familywise,
        "error_before": one.before.error.value,
        "error_after": one.after.error.value,
        "alike": _alike(proposed, form, one.alike),
        "alike_effects": list(one.alike_effects),
        "shapes": list(one.shapes),
        "within": ALIAS_WITHIN,
        "hint": hint_for(form.slot, form.argument, form.shape_name, rising=rises(proposed, one)),
        "next_shots": shots_document(following),
    }


def _alike(
    proposed: Proposed, form: Form | LaunchForm, groups: Sequence[tuple[str, str]]
) -> list[Json]:
    """Return what else may be meant: the argument by its other names, then other groups."""
    copies = [(form.slot, name) for name in proposed.admitted.copies(form.argument)]
    return [{"slot": slot, "argument": argument} for slot, argument in (*copies, *groups)]


def _of_launch(proposed: Proposed, one: LaunchProposal, following: Sequence[Repeated]) -> Json:
    """Return a form of the launch; shots of the contact tell nothing of it, nor its effects."""
    form, rising = one.form, next(iter(one.parameters.values())).value > 0
    return {
        "slot": form.slot,
        "argument": form.argument,
        "shape": form.shape_name,
        "name": one.name,
        "formula": formula(form),
        "latex": latex(form),
        "parameters": {name: quantity.to_json() for name, quantity in one.parameters.items()},
        "p_familywise": one.p_familywise,
        "error_before": one.error_before,
        "error_after": one.error_after,
        "alike": _alike(proposed, form, one.alike),
        "alike_effects": [],
        "shapes": list(one.shapes),
        "within": ALIAS_WITHIN,
        "hint": hint_for(form.slot, form.argument, form.shape_name, rising=rising),
        "next_shots": shots_document(following),
    }


def rises(proposed: Proposed, one: Accepted) -> bool:
    """Whether a coefficient rises with its argument, on the whole of the shots."""
    values = next(a.values for a in one.found.fit.theory.active if a.effect.name == one.name)
    form = one.form
    if not isinstance(form, ContactForm):
        return bool(values[0] > 0)
    if form.shape is POWER:
        return bool(values[0] > 0)
    encounter = proposed.encounter
    change = form.columns(encounter) @ values
    along = form.arguments[0].of(encounter)[:, 0]
    return bool(np.cov(change, along)[0, 1] > 0)


def confirmation_document(campaign: str, found: Confirmation) -> Json:
    """Return the document of `rigctl model propose --confirm --json`."""
    return {
        "campaign": campaign,
        "used": found.shots,
        "with": list(found.beside),
        "effect": found.effect.name,
        "confirmed": found.confirmed,
        "fall": found.delta_chi2,
        "p_value": max(found.p_value, SMALLEST_P),
        "error_before": found.error_before,
        "error_after": found.error_after,
        "parameters": {name: q.to_json() for name, q in found.parameters.items()},
    }


def together_document(campaigns: Sequence[str], found: Together) -> Json:
    """Return the document of several campaigns asked at once."""
    return {
        "campaigns": list(campaigns),
        "with": [
            {"campaign": name, "effects": list(effects)}
            for name, effects in zip(campaigns, found.effects, strict=True)
        ],
        "verdict": "proposal" if found.forms else "none",
        "shared": [
            {
                "slot": one.slot,
                "argument": one.argument,
                "shape": one.shape,
                "constants": list(one.constants),
                "amplitude": one.amplitude,
                "sigma": one.sigma,
                "p_familywise": one.p_familywise,
                "p_alike": max(one.p_alike, SMALLEST_P),
                "each": [
                    {"campaign": name, "amplitude": amplitude, "sigma": sigma}
                    if np.isfinite(sigma)
                    else {"campaign": name, "amplitude": None, "sigma": None}
                    for name, (amplitude, sigma) in zip(campaigns, one.each, strict=True)
                ],
            }
            for one in found.forms
        ],
    }
