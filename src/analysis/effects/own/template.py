"""Template file for a user's own effect, which works unchanged and is off; the form of its name."""

from __future__ import annotations

import re
from string import Template

NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
FORM = "lower case letters and figures, words joined by hyphens, as in restitution-drift"
LONGEST = 64


def well_formed(name: str) -> bool:
    """Whether a name has the form that commands, files and the API can carry."""
    return len(name) <= LONGEST and NAME.fullmatch(name) is not None


_HEAD = '''"""What the effect is, in one sentence."""

from __future__ import annotations

'''
_TAIL = """
    source="where the formula and the plausible range come from",
    gives_away="which residual follows what: by this a reader knows the effect",
"""

_CONTACT = '''from dataclasses import replace

from rigctl import ContactEffect, Encounter, Operator, Outcome, Parameter, Values


def wrap(operator: Operator, values: Values) -> Operator:
    """Change e, mu or beta0 by what is known of an encounter: speeds in m/s, columns of shots."""

    def changed(encounter: Encounter) -> Outcome:
        factor = 1.0 + values[0] * encounter.approach
        return operator(replace(encounter, e=encounter.e * factor))

    return changed


EFFECT = ContactEffect(
    name="$name",
    title="$title",
    parameters=(
        Parameter(symbol="a", unit="s/m", meaning="change of e per m/s", plausible=(-0.05, 0.05)),
    ),
    formula="e = e0 (1 + a v_n)",'''

_FLIGHT = '''import numpy as np

from rigctl import FlightEffect, Floats, Flying, Parameter, Values


def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
    """Return what is added to acceleration, m/s^2, and angular acceleration, rad/s^2."""
    return -values[0] * flying.velocity, np.zeros_like(flying.spin)


EFFECT = FlightEffect(
    name="$name",
    title="$title",
    parameters=(
        Parameter(symbol="k", unit="1/s", meaning="rate of slowing down", plausible=(-0.5, 0.5)),
    ),
    formula="acceleration = -k v",'''

_CAMERA = '''import numpy as np

from rigctl import CameraEffect, CameraSetup, Floats, Parameter, Values


def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
    """Return where the images show centres that are at `position`: X down, Y right, Z near, m."""
    x, y, z = np.moveaxis(position, -1, 0)
    return np.stack([x + values[0] * y, y, z], axis=-1)


EFFECT = CameraEffect(
    name="$name",
    title="$title",
    parameters=(
        Parameter(symbol="s", unit="1", meaning="shear of the picture", plausible=(-0.02, 0.02)),
    ),
    formula="x' = x + s y",'''

_CLOCK = '''from rigctl import CameraSetup, ClockEffect, Exposure, Floats, Parameter, Values


def expose(exposure: Exposure, camera: CameraSetup, values: Values) -> tuple[Floats, Floats]:
    """Return true times, s: of positions, to (S, F, 2, 3), and of orientations, to (S, F, 2)."""
    true = exposure.times_s + values[0] * exposure.times_s**2
    return true[..., None, None], true[..., None]


EFFECT = ClockEffect(
    name="$name",
    title="$title",
    parameters=(
        Parameter(symbol="w", unit="1/s", meaning="growth of frame time", plausible=(-0.1, 0.1)),
    ),
    formula="t_true = t + w t^2",'''

_STAGES = {
    "contact": (_CONTACT, "wrap=wrap"),
    "flight": (_FLIGHT, "accelerate=accelerate"),
    "camera": (_CAMERA, "appear=appear"),
    "clock": (_CLOCK, "expose=expose"),
}


def template(name: str, stage: str) -> str:
    """Return the text of a file that defines an effect.

    Parameters
    ----------
    stage
        Where it acts: contact, flight, camera or clock.

    Raises
    ------
    KeyError
        There is no such stage.
    """
    body, function = _STAGES[stage]
    title = name.replace("-", " ").capitalize()
    text = Template(_HEAD + body + _TAIL).substitute(name=name, title=title)
    return f"{text}    {function},\n)\n"
