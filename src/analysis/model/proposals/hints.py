"""The nearest known physics of a proposal, in words: a hint, never a finding.

What depends on what, in which direction, and where the literature has met it.
"""

from __future__ import annotations

from dataclasses import dataclass


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
