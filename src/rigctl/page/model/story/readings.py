"""What a size of an effect does, in a sentence: what the slider says while it is moved.

Each sentence follows from the formula that the effect states, to the digits that it is read with;
of the viscoelastic law it is the first order, exact to a hundredth of e within its expected range.
"""

from __future__ import annotations

import math
from collections.abc import Callable

SLOW, FAST = 1.0, 8.0
"""Speeds at which a law of speed is read, m/s."""
REFERENCE = 2.0
"""At which the laws keep the fit's own coefficient, m/s."""
DEGREES = 180.0 / math.pi
FIGURES = 2
Reading = Callable[[float, float], str]
"""Sentence of an amplitude, in the parameter's own unit, and of the fit's bounce e."""


def said(value: float, unit: str = "", figures: int = FIGURES) -> str:
    """Return a number with its unit, a true minus, and no power of ten where it can be helped."""
    text = f"{value:.{figures}g}"
    if "e" in text:
        text = f"{value:.0f}" if abs(value) >= 1 else f"{value:.{figures + 5}f}".rstrip("0")
    return f"{text.rstrip('.') or '0'}{unit}".replace("-", "−")


def changed(share: float, more: str = "more", less: str = "less") -> str:
    """Return a share of change as `3 % more`."""
    return f"{said(abs(100 * share))} % {more if share >= 0 else less}"


def sentence_of(effect: str, amplitude: float, bounce: float) -> str:
    """Return what an amplitude of an effect does; empty where no sentence is known."""
    reading = READINGS.get(effect)
    return "" if reading is None else f"{reading(amplitude, bounce)}."


def _viscoelastic(a: float, e: float) -> str:
    slow, fast = (e * (1 - a * (v**0.2 - REFERENCE**0.2) / 0.2) for v in (SLOW, FAST))
    return _from_to(slow, fast)


def _from_to(slow: float, fast: float) -> str:
    return (
        f"The bounce goes from {slow:.2f} at {SLOW:g} m/s to {fast:.2f} at {FAST:g} m/s"
    ).replace("-", "−")


def _powers(p: float, e: float) -> str:
    slow, fast = (min(1.0, e * (v / REFERENCE) ** -p) for v in (SLOW, FAST))
    return _from_to(slow, fast)


def _knee(p: float, e: float) -> str:
    fast = e * (FAST / REFERENCE) ** -p
    return f"The bounce stays {e:.2f} up to {REFERENCE:g} m/s and is {fast:.2f} at {FAST:g} m/s"


READINGS: dict[str, Reading] = {
    "restitution-viscoelastic": _viscoelastic,
    "restitution-plastic": _powers,
    "restitution-yield-knee": _knee,
    "restitution-obliquity": lambda a, _: f"A hit at 45° bounces {changed(a)} than a head-on one",
    "restitution-drift": lambda a, _: f"The last shot bounces {changed(a)} than the first",
    "velocity-offset": lambda u, _: (
        f"Every rebound is {said(abs(1e3 * u))} mm/s {'faster' if u >= 0 else 'slower'}"
    ),
    "adhesion": lambda a, _: (
        f"A rebound at 1 m/s {'loses' if a >= 0 else 'gains'} {said(abs(1e3 * a))} mm/s"
    ),
    "finite-contact": lambda a, _: f"The contact lasts {said(a)} times as long as Hertz says",
    "lasting-contact": lambda t, _: f"A contact at 1 m/s lasts {said(1e3 * t)} ms",
    "tangential-compliance": lambda a, _: (
        f"The skin gives {said(100 * a)} % of what elastic theory says"
    ),
    "friction-speed": lambda a, _: (
        f"Friction at 5 m/s is {changed(a * math.log(5.0))} than at 1 m/s"
    ),
    "friction-drift": lambda a, _: f"The last shot has {changed(a)} friction than the first",
    "rolling-restitution-speed": lambda a, _: (
        f"At 6 m/s {changed(a * math.log(3.0))} of the sliding comes back than at 2 m/s"
    ),
    "torsional-friction": lambda c, _: f"The contact patch is {said(2e3 * c)} mm wide at 2 m/s",
    "inertia-factor": lambda k, _: (
        f"The spheres are {changed(k, 'harder', 'easier')} to spin than solid ones; 67 % is a "
        "thin shell"
    ),
    "mass-mismatch": lambda d, _: (
        f"Sphere a is {changed(2 * d, 'heavier', 'lighter')} than sphere b"
    ),
    "drag": lambda c, _: f"Its drag coefficient is {said(c)}; a smooth sphere has 0.40 to 0.45",
    "buoyancy": lambda b, _: f"Spheres fall {said(0.16 * b)} % too slowly",
    "spin-decay": lambda k, _: (
        f"The air slows the spin {said(k)} times as much as it slows a sphere that turns in still "
        "air"
    ),
    "gravity-value": lambda dg, _: f"Gravity here is {9.807 + dg:.3f} m/s²",
    "image-scale": lambda s, _: f"1 mm is measured as {1 + s:.4f} mm",
    "pixel-aspect": lambda a, _: f"Pixels are {changed(a, 'taller', 'flatter')} than wide",
    "radial-distortion": lambda k, _: (
        f"A corner of the picture lies {changed(k, 'too far out', 'too far in')}"
    ),
    "perspective": lambda q, _: (
        f"The camera stands {said(1 / q)} m from the spheres"
        if q > 0
        else "The camera stands very far away"
    ),
    "mirror-angle": lambda d, _: f"The mirror stands at {45 + DEGREES * d:.2f}°, not at 45°",
    "camera-roll": lambda s, _: f"The camera is turned by {said(DEGREES * s)}°",
    "frame-rate": lambda r, _: (
        f"The camera takes {1000 * (1 - r):.1f} pictures where 1000 are stated"
    ),
    "timing-jitter": lambda s, _: f"Pictures come {said(1e6 * s)} µs early or late",
    "exposure-offset": lambda d, _: (
        f"The outline is seen {said(abs(1e6 * d))} µs {'after' if d >= 0 else 'before'} the dots"
    ),
    "pressure-hysteresis": lambda h, _: (
        f"After a step up the spheres are {changed(h, 'faster', 'slower')}"
    ),
    "pressure-leak": lambda k, _: (
        f"After 30 s {said(100 * (1 - math.exp(-30 * k)))} % of the pressure is gone"
    ),
    "launch-delay": lambda t, _: (
        f"Valve b opens {said(abs(1e3 * t))} ms {'later' if t >= 0 else 'earlier'} than a"
    ),
    "tube-spin": lambda c, _: f"The spheres spin {said(100 * c)} % of full rolling",
}
