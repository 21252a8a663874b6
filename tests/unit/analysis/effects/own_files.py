"""Files of effects as a user would write them, sound ones and others, with the line that matters.

A line that ends in `# HERE` is the one that a fault must name.
"""

from __future__ import annotations

from pathlib import Path

HERE = "# HERE"

IMPORTS = """\
from dataclasses import replace

import numpy as np

from analysis.effects.effect import CameraEffect, ClockEffect, ContactEffect, FlightEffect
from analysis.effects.effect import Parameter
"""

CLASSES = {
    "wrap": "ContactEffect",
    "accelerate": "FlightEffect",
    "appear": "CameraEffect",
    "expose": "ClockEffect",
}


def text_of(
    function: str,
    *,
    name: str = "of-my-own",
    unit: str = "1",
    plausible: str = "(-0.1, 0.1)",
    more: str = "",
    here: str = "",
) -> str:
    """Return a file whose effect acts by `function`, a definition of wrap, accelerate, ..."""
    [called] = [name for name in CLASSES if f"def {name}(" in function]
    return (
        f"{IMPORTS}\n\n{function}\n\n\nEFFECT = {CLASSES[called]}(  {here}\n"
        f"    name={name!r},\n    title='Of my own',\n"
        f"    parameters=(Parameter('a', {unit!r}, 'its size', {plausible}{more}),),\n"
        f"    formula='f', source='s', gives_away='g', {called}={called},\n)\n"
    )


def write(folder: Path, text: str, name: str = "of-my-own") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.py"
    path.write_text(text, encoding="utf-8")
    return path


def line_here(text: str) -> int:
    """Return the line that is marked, counted from 1."""
    [line] = [n for n, row in enumerate(text.splitlines(), start=1) if row.endswith(HERE)]
    return line


STRETCH = """\
def appear(position, camera, values):
    return position * (1.0 + values[0])"""

SLOWING = """\
def accelerate(flying, values):
    return -values[0] * flying.velocity, np.zeros_like(flying.spin)"""

DRIFT = """\
def wrap(operator, values):
    def changed(encounter):
        factor = 1.0 + values[0] * encounter.covariates["order"]
        return operator(replace(encounter, e=encounter.e * factor))
    return changed"""

LATE = """\
def expose(exposure, camera, values):
    stated = exposure.times_s[..., None]
    return stated[..., None] + values[0], stated"""
