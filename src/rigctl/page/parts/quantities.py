"""What each quantity is and in which unit: the words that the page shows on hover."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity as a table names it, with its unit (empty for a ratio) and its definition.

    Attributes
    ----------
    per_si
        How many of the unit make one of the SI unit that results hold; negative where the page
        shows the opposite.
    """

    name: str
    unit: str
    meaning: str
    per_si: float = 1.0


COEFFICIENTS = {
    "e": Quantity(
        "bounce e",
        "",
        "Normal restitution, -v_n′ / v_n: 1 loses nothing; at 0 the spheres do not part.",
    ),
    "beta": Quantity(
        "spin-back β",
        "",
        "Tangential restitution, -v_s′ / v_s: 1 reverses the sliding, -1 leaves it.",
    ),
    "v_n": Quantity(
        "approach |v_n|",
        "m/s",
        "Speed of approach along the line of centres. Files hold v_n with its sign, the normal "
        "relative velocity (V_b - V_a) · n with n from a to b: negative while the spheres "
        "approach (section 7.1).",
        per_si=-1.0,
    ),
    "v_n_after": Quantity(
        "parting v_n′", "m/s", "Normal relative velocity after contact; positive while they part."
    ),
    "v_s": Quantity(
        "sliding v_s",
        "m/s",
        "Surface velocity before contact: how fast the two surfaces slide over each other at the "
        "point of contact, spin included; a length (section 7.1).",
    ),
    "v_s_after": Quantity(
        "sliding v_s′",
        "m/s",
        "Surface velocity after contact along the direction it had before; negative when the "
        "surfaces have turned their sliding about.",
    ),
    "contact_duration": Quantity(
        "contact T",
        "µs",
        "Duration of contact: from first touch on the paths before it to the parting on the paths "
        "after it. The tracks' kink lies e / (1 + e) of it after first touch.",
        per_si=1e6,
    ),
}
PARAMETERS = {
    "e": Quantity("e", "", "Normal restitution of the model."),
    "mu": Quantity("μ", "", "Coulomb's coefficient of sliding friction in the contact."),
    "beta0": Quantity("β₀", "", "Tangential restitution of contacts that stick (Walton)."),
}
EXPECTED = {"e": (0.0, 1.0), "mu": (0.0, 1.0), "beta0": (-1.0, 1.0)}
"""Of the parameters above: more restitution than 1 would make energy."""
SETTINGS = {
    "pressure_a_kpa": Quantity(
        "Pressure a", "kPa", "Gauge pressure of the pusher of sphere a; it sets the speed."
    ),
    "pressure_b_kpa": Quantity(
        "Pressure b", "kPa", "Gauge pressure of the pusher of sphere b; it sets the speed."
    ),
    "offset_mm": Quantity(
        "Offset",
        "mm",
        "Vertical offset of tube b below tube a. At 0 the spheres meet head on; near a diameter "
        "(25.4 mm) they graze.",
    ),
    "delay_us": Quantity("Delay of b", "µs", "Pusher b fires this much later than pusher a."),
    "angle_a_deg": Quantity("Tilt a", "°", "Tilt of tube a below the horizontal."),
    "angle_b_deg": Quantity("Tilt b", "°", "Tilt of tube b below the horizontal."),
}
VALUE = (
    "Value with its standard error: were it measured again and again, two results of three would "
    "lie so near the truth."
)
REBOUND = (
    "Surface velocity after contact over that before, both in units of the approach speed |v_n|. "
    "Where the spheres stick, -β₀ is the slope; where they slide, friction takes μ (1 + e) (1 + "
    "1/K) away (section 7.1)."
)
SPEED = "e of each shot over |v_n|, the speed at which the spheres approach along the normal."
INCIDENCE = (
    "β of each shot over v_s / |v_n|: small where the spheres meet head on, large where they "
    "graze. Dotted: β = -1, a contact without friction."
)
CHI2 = (
    "Sum of the squared residuals in units of their noise, by degree of freedom. 1 is what noise "
    "alone gives."
)
ERROR = (
    "Root mean square error of the prediction in units of the measurement's own noise. 1 is the "
    "floor: nothing can predict better than what it is compared with is known."
)
CHANCE = "Chance that noise alone does as much, with all lines looked at."
FALL = "By how much χ² would fall if this effect were added."
SCORE = "Root of the fall of χ² expected from the effect: standard deviations of its amplitude."
PLAUSIBLE = "The range expected on this rig. An effect outside it is marked, not hidden."
LIKE = (
    "Effects with one letter do the same to these shots (correlation above 0.9): only other shots "
    "tell them apart."
)
