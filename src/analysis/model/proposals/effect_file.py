"""A proposal as an effect file: what `--with`, `explain` and `rank` load like any of one's own."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from textwrap import fill

from analysis.effects.effect import FlightEffect, Parameter
from analysis.effects.own.guard import FUNCTIONS
from analysis.model.proposals.channels import Form
from analysis.model.proposals.forms.flight import FlightForm
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.forms.frame import FrameForm
from analysis.model.proposals.forms.impulses import IMPULSE_N, IMPULSE_T, TORSION
from analysis.model.proposals.forms.launch import LaunchForm
from analysis.model.proposals.forms.shapes import POWER
from analysis.model.proposals.proposed import Accepted, Proposed
from analysis.model.proposals.stated import Origin, Statement
from analysis.model.proposals.wording import formula

CAMPAIGN, SHOTS, BESIDE = "PROPOSED_FROM", "SHOTS_SEEN", "FITTED_BESIDE"
"""Constants of a file: where its form was chosen, and beside which effects. A test of it needs
other shots and the same effects."""
_HEAD = '''"""{title}.

{told}
"""

from __future__ import annotations

{imports}
'''
_CONTACT_IMPORTS = """from dataclasses import replace

import numpy as np

from rigctl import ContactEffect, Encounter, Floats, Operator, Outcome, Parameter, Values
"""
_FLIGHT_IMPORTS = """import numpy as np

from rigctl import FlightEffect, Floats, Flying, Parameter, Values
"""
_WRAP = '''

def columns(encounter: Encounter) -> Floats:
    """Return what the amplitudes multiply, one column each, for every shot."""
{columns}


def wrap(operator: Operator, values: Values) -> Operator:
    """{doc}"""

    def changed(encounter: Encounter) -> Outcome:
{changed}

    return changed


EFFECT = ContactEffect('''
_SCALED = """        change = columns(encounter) @ values
        return operator(replace(encounter, {slot}=encounter.{slot} * {factor}))"""
_TWISTED = """        outcome, (a, b) = operator(encounter), encounter.bodies
        push = (1 + encounter.e) * encounter.approach.clip(min=0.0)
        push = push / (1 / a.mass + 1 / b.mass)
        spins = encounter.before.spin_b - encounter.before.spin_a
        relative = (spins * encounter.normal).sum(axis=1)
        torque = 3 * np.pi / 16 * encounter.mu * push * np.sign(relative)
        twist = (torque * (columns(encounter) @ values))[:, None] * encounter.normal
        after = outcome.after
        spin_a = after.spin_a + twist / a.inertia
        spin_b = after.spin_b - twist / b.inertia
        return replace(outcome, after=replace(after, spin_a=spin_a, spin_b=spin_b))"""
_PUSHED = """        outcome, (a, b) = operator(encounter), encounter.bodies
        change = columns(encounter) @ values
        normal, before, after = encounter.normal, encounter.before, outcome.after
        along = 1 / a.mass + 1 / b.mass
{impulse}
        more = ({factor})[:, None] * impulse
        twist = np.cross(normal, more)
        states = replace(
            after,
            velocity_a=after.velocity_a - more / a.mass,
            velocity_b=after.velocity_b + more / b.mass,
            spin_a=after.spin_a - a.radius / a.inertia * twist,
            spin_b=after.spin_b - b.radius / b.inertia * twist,
        )
        return replace(outcome, after=states)"""
_IMPULSE = {
    IMPULSE_N: """        gained = after.velocity_b - after.velocity_a
        gained = gained - before.velocity_b + before.velocity_a
        impulse = (gained * normal).sum(axis=1)[:, None] * normal / along""",
    IMPULSE_T: """        relative = after.velocity_b - after.velocity_a
        turning = a.radius * after.spin_a + b.radius * after.spin_b
        slip = relative - (relative * normal).sum(axis=1)[:, None] * normal
        slip = slip + np.cross(normal, turning)
        across = along + a.radius**2 / a.inertia + b.radius**2 / b.inertia
        impulse = (slip - encounter.sliding) / across""",
}
_DOCS = {
    TORSION: "Brake the spin about the normal.",
    IMPULSE_N: "Change the impulse along the normal alone.",
    IMPULSE_T: "Change the impulse across the normal.",
}
_ACCELERATE = '''

def accelerate(flying: Flying, values: Values) -> tuple[Floats, Floats]:
    """Return what is added to acceleration, m/s^2, and angular acceleration, rad/s^2."""
    still = np.zeros_like(flying.spin)
{body}


EFFECT = FlightEffect('''
_BODIES = {
    "uniform": "    return np.zeros_like(flying.velocity) + values, still",
    "velocity": """    speed = np.linalg.norm(flying.velocity, axis=-1, keepdims=True)
    speed = speed.clip(min=1e-6)
    return -values[0] * speed ** (Q - 1.0) * flying.velocity, still""",
    "central": """    if flying.partner is None:
        return still, still
    apart = flying.partner - flying.position
    distance = np.linalg.norm(apart, axis=-1, keepdims=True).clip(min=TOUCHING / 2)
    size = (MASS / flying.body.mass) * (TOUCHING / distance) ** P
    return values[0] * size * apart / distance, still""",
    "central-exponential": """    if flying.partner is None:
        return still, still
    apart = flying.partner - flying.position
    distance = np.linalg.norm(apart, axis=-1, keepdims=True).clip(min=TOUCHING / 2)
    size = (MASS / flying.body.mass) * np.exp(-(distance - TOUCHING) / C)
    return values[0] * size * apart / distance, still""",
}


_CAMERA_IMPORTS = """import numpy as np

from rigctl import CameraEffect, CameraSetup, Floats, Parameter, Values
"""
_APPEAR = '''

def appear(position: Floats, camera: CameraSetup, values: Values) -> Floats:
    """Return where the images show centres that are at `position`: X down, Y right, Z near, m."""
    places = np.moveaxis(position, -1, 0)
    moved = [*places]
    moved[{along}] = moved[{along}] + values[0] * places[{by}]{square}
    return np.stack(moved, axis=-1)


EFFECT = CameraEffect('''
_CLOCK_IMPORTS = """import numpy as np

from rigctl import CameraSetup, ClockEffect, Exposure, Floats, Parameter, Values
"""
_EXPOSE = '''

def expose(exposure: Exposure, camera: CameraSetup, values: Values) -> tuple[Floats, Floats]:
    """Return true times, s: of positions, to (S, F, 2, 3), and of orientations, to (S, F, 2)."""
    stated = exposure.times_s[..., None]
    true = stated + {change}
    return true[..., None], true


EFFECT = ClockEffect('''
_SQUARE = "values[0] * stated**2"
_PERIODIC = """(
        values[0] * np.sin(2 * np.pi * F * stated) + values[1] * np.cos(2 * np.pi * F * stated)
    )"""


def effect_name(form: Form | LaunchForm) -> str:
    """Return the name of a proposal's effect: what depends on what, and how."""
    words = f"proposed-{form.slot}-{form.argument}-{form.shape_name}".replace("*", "-times-")
    return "".join(c if c.isalnum() else "-" for c in words.lower())


def written(folder: Path, campaign: str, proposed: Proposed) -> list[Path]:
    """Write every proposal into a folder, each a file of its own.

    What acts from the flight on is an effect; a law of the launch is stated as numbers.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths, chosen = [], Origin.of(campaign, proposed)
    for one in proposed.accepted:
        path = folder / f"{effect_name(one.form).replace('-', '_')}.py"
        path.write_text(text_of(one, chosen), encoding="utf-8")
        paths.append(path)
    for law in proposed.launch:
        path = folder / f"{effect_name(law.form).replace('-', '_')}.json"
        document = {
            "proposed": formula(law.form),
            "parameters": {name: q.to_json() for name, q in law.parameters.items()},
            "form": Statement.of(law.form, chosen).document(),
        }
        path.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
        paths.append(path)
    return paths


def text_of(one: Accepted, chosen: Origin) -> str:
    """Return the file of one proposal, which says from which shots it comes."""
    form = one.form
    found = ", ".join(
        f"{name} = {q.concise()}{'' if q.unit == '1' else ' ' + q.unit}"
        for name, q in one.quantities.items()
    )
    told = fill(
        f"Proposed from what a fit of {chosen.campaign} left over: {found}. Its scales are "
        "constants of this file; what it is multiplied by is fitted again.",
        99,
    )
    head = _HEAD.format(
        title=formula(form).rstrip("."),
        told=told,
        imports=_imports(form),
    )
    seen = f"\n{CAMPAIGN} = {chosen.campaign!r}\n{SHOTS} = {chosen.shots!r}"
    seen += f"\n{BESIDE} = {', '.join(chosen.beside)!r}"
    constants = "".join(f"\n{name} = {value!r}" for name, value in _named(form).items())
    function = _function(form) + _declaration(form, chosen.campaign)
    return head.rstrip("\n") + "\n" + seen + constants + "\n" + function


def origin(path: Path) -> Origin | None:
    """Return where the form of a file was chosen; None: it names no campaign."""
    found: dict[str, str] = {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name, value = node.targets[0].id, node.value
            if name in {CAMPAIGN, SHOTS, BESIDE} and isinstance(value, ast.Constant):
                found[name] = str(value.value)
    if CAMPAIGN not in found or SHOTS not in found:
        return None
    beside = tuple(name for name in found.get(BESIDE, "").split(", ") if name)
    return Origin(found[CAMPAIGN], found[SHOTS], beside)


def _imports(form: Form) -> str:
    if isinstance(form, FrameForm):
        return _CAMERA_IMPORTS if form.slot == "camera" else _CLOCK_IMPORTS
    return _FLIGHT_IMPORTS if isinstance(form, FlightForm) else _CONTACT_IMPORTS


def _named(form: Form) -> dict[str, float]:
    """Return the constants of a form by the names that its file has for them."""
    if isinstance(form, FlightForm):
        central = form.kind.startswith("central")
        own = {"TOUCHING": form.touching, "MASS": form.mass} if central else {}
        scales = zip(form.free, form.constants, strict=True)
        return {**own, **{name.upper(): float(value) for name, value in scales}}
    if isinstance(form, FrameForm):
        return {"F": form.constants[0]} if form.constants else {}
    if len(form.arguments) == 2:
        return {f"ZERO_{k + 1}": float(value) for k, value in enumerate(form.constants)}
    names = () if form.shape is None else form.shape.constants
    return {_found(name): float(v) for name, v in zip(names, form.constants, strict=True)}


def _found(name: str) -> str:
    """Return what a file calls a constant, so that no letter of a formula is it as well."""
    return f"FOUND_{name.upper()}"


def _function(form: Form) -> str:
    if isinstance(form, FlightForm):
        return _ACCELERATE.format(body=_BODIES[form.kind])
    if isinstance(form, FrameForm) and form.slot == "camera":
        square = "**2" if form.kind == "power" else ""
        return _APPEAR.format(along=form.along, by=form.by, square=square)
    if isinstance(form, FrameForm):
        return _EXPOSE.format(change=_SQUARE if form.kind == "power" else _PERIODIC)
    return _WRAP.format(
        columns=_columns(form),
        doc=_DOCS.get(form.slot, f"Change {form.slot}."),
        changed=_changed(form),
    )


def _changed(form: ContactForm) -> str:
    """Return the lines that change what a contact leaves behind."""
    power = form.shape is POWER
    if form.slot == TORSION:
        return _TWISTED
    if form.slot in _IMPULSE:
        factor = "np.exp(change) - 1.0" if power else "change"
        return _PUSHED.format(impulse=_IMPULSE[form.slot], factor=factor)
    factor = "np.exp(change)" if power else "(1.0 + change)"
    return _SCALED.format(slot=form.slot, factor=factor)


def _columns(form: ContactForm) -> str:
    if len(form.arguments) == 2:
        parts = [
            f"np.log(np.maximum({argument.codes[0]}, 1e-9) / ZERO_{k + 1})"
            if argument.positive
            else f"({argument.codes[0]} - ZERO_{k + 1})"
            for k, argument in enumerate(form.arguments)
        ]
        lines = [f"first = {parts[0]}", f"second = {parts[1]}"]
        return _lines([*lines, "return (first * second)[:, None]"])
    if form.shape is None:
        codes = form.arguments[0].codes
        named = [f"column_{k} = {code}" for k, code in enumerate(codes)]
        stacked = ", ".join(f"column_{k}" for k in range(len(codes)))
        return _lines([*named, f"return np.stack([{stacked}], axis=1)"])
    names = form.shape.constants
    lines = [f"x = {form.arguments[0].codes[0]}"]
    lines += [f"{name} = {_found(name)}" for name in names]
    return _lines([*lines, f"return np.stack([{', '.join(form.shape.codes)}], axis=1)"])


def _lines(lines: list[str]) -> str:
    return "\n".join(f"    {line}" for line in lines)


def _declaration(form: Form, campaign: str) -> str:
    effect = form.effect(effect_name(form))
    texts = {
        "name": effect.name,
        "title": effect.title,
        "formula": formula(form),
        "source": f"proposed from what a fit of {campaign} left over",
        "gives_away": effect.gives_away,
    }
    lines = [f"    {name}={text!r}," for name, text in texts.items()]
    lines += [
        "    parameters=(",
        *(f"        {_parameter(p)}," for p in effect.parameters),
        "    ),",
    ]
    lines.append(f"    {FUNCTIONS[effect.stage]}={FUNCTIONS[effect.stage]},")
    if isinstance(effect, FlightEffect):
        lines.append(f"    nodes={effect.nodes},")
    return "\n".join(["", *lines, ")", ""])


def _parameter(parameter: Parameter) -> str:
    low, high = parameter.plausible
    return (
        f"Parameter(symbol={parameter.symbol!r}, unit={parameter.unit!r}, "
        f"meaning={parameter.meaning!r}, plausible=({low!r}, {high!r}), step={parameter.step!r})"
    )
