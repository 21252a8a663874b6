"""An effect is tried before use: silent where it is off, seen where it is on, in its unit."""

from __future__ import annotations

import inspect
from pathlib import Path

import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import ContactLaw, Effect
from analysis.effects.own.checking import checked
from analysis.effects.own.guard import FUNCTIONS, function_of
from analysis.effects.own.loading import Loaded, load_effects
from tests.unit.analysis.effects.own_files import (
    HERE,
    LATE,
    SLOWING,
    STRETCH,
    line_here,
    text_of,
    write,
)

TRIED = [e for e in CATALOGUE if e.stage in FUNCTIONS and not isinstance(e, ContactLaw)]


@pytest.mark.parametrize("effect", TRIED, ids=lambda effect: effect.name)
def test_every_effect_of_the_catalogue_passes_the_trial(effect: Effect) -> None:
    path = Path(inspect.getfile(function_of(effect)))
    assert checked(effect, path, 1).name == effect.name


def loaded(folder: Path, text: str) -> Loaded:
    write(folder, text)
    return load_effects(folder, CATALOGUE)


MISBEHAVING = {
    "raises": (
        text_of("def appear(position, camera, values):\n    return position * scale  " + HERE),
        "raised NameError",
    ),
    "raises in a function it calls": (
        text_of(
            "def scale(values):\n    return values[1]  " + HERE + "\n\n\n"
            "def appear(position, camera, values):\n    return position * scale(values)"
        ),
        "raised IndexError",
    ),
    "takes other arguments": (
        text_of("def appear(position, values):  " + HERE + "\n    return position"),
        "raised TypeError",
    ),
    "returns NaN": (
        text_of(
            "def appear(position, camera, values):  " + HERE + "\n"
            "    return position * (1.0 + np.sqrt(values[0]))"
        ),
        "not finite at a = -0.",
    ),
    "divides by nothing": (
        text_of(
            "def accelerate(flying, values):  " + HERE + "\n"
            "    still = np.zeros_like(flying.spin)\n"
            "    return flying.velocity / values[0], still"
        ),
        "not finite at a = 0",
    ),
    "returns nothing": (
        text_of("def appear(position, camera, values):  " + HERE + "\n    position * 2"),
        "returned nothing for position",
    ),
    "returns a wrong shape": (
        text_of(
            "def appear(position, camera, values):  " + HERE + "\n    return position[..., :2]"
        ),
        "of shape (16, 6, 2, 2)",
    ),
    "returns words": (
        text_of(
            "def appear(position, camera, values):  " + HERE + "\n    return position.astype(str)"
        ),
        "for position",
    ),
    "returns one of two": (
        text_of(
            "def accelerate(flying, values):  " + HERE + "\n    return -values[0] * flying.velocity"
        ),
        "a value of type ndarray",
    ),
    "returns times that do not spread": (
        text_of(
            "def expose(exposure, camera, values):  " + HERE + "\n"
            "    return exposure.times_s, exposure.times_s",
            unit="s",
        ),
        "times of position of shape (16, 6)",
    ),
    "returns no operator": (
        text_of("def wrap(operator, values):  " + HERE + "\n    return values"),
        "not an operator",
    ),
    "returns no outcome": (
        text_of(
            "def wrap(operator, values):  " + HERE + "\n    return lambda encounter: encounter"
        ),
        "type Encounter",
    ),
    "writes into what it is given": (
        text_of(
            "def appear(position, camera, values):\n"
            "    position *= 1.0 + values[0]  " + HERE + "\n    return position"
        ),
        "read-only",
    ),
    "changes something where it is off": (
        text_of(
            "def appear(position, camera, values):  "
            + HERE
            + "\n    return position * 1.01 + values[0]"
        ),
        "changes something where it is off (a = 0)",
    ),
    "changes nothing": (
        text_of("def appear(position, camera, values):  " + HERE + "\n    return position.copy()"),
        "changes nothing up to -0.1",
    ),
    "changes too little for anyone to see": (
        text_of(
            "def appear(position, camera, values):  " + HERE + "\n"
            "    return position * (1.0 + 1e-9 * values[0])"
        ),
        "changes nothing up to",
    ),
    "draws by chance": (
        text_of(
            "def appear(position, camera, values):  " + HERE + "\n"
            "    rng = np.random.default_rng()\n"
            "    return position + values[0] * rng.normal(size=position.shape)"
        ),
        "another answer when it is asked again",
    ),
    "remembers": (
        text_of(
            "calls = []\n\n\n"
            "def appear(position, camera, values):  " + HERE + "\n"
            "    calls.append(1)\n"
            "    return position * (1.0 + values[0] * len(calls))"
        ),
        "another answer when it is asked again",
    ),
    "takes a mean over the shots": (
        text_of(
            "def wrap(operator, values):  " + HERE + "\n"
            "    def changed(encounter):\n"
            "        usual = encounter.approach / encounter.approach.mean()\n"
            "        return operator(replace(encounter, e=encounter.e * (1 + values[0] * usual)))\n"
            "    return changed"
        ),
        "depend on the others",
    ),
    "counts the rows": (
        text_of(
            "def accelerate(flying, values):  " + HERE + "\n"
            "    rows = np.arange(len(flying.velocity))[:, None, None]\n"
            "    return -values[0] * rows * flying.velocity, np.zeros_like(flying.spin)",
            unit="1/s",
        ),
        "depend on the others",
    ),
    "begins with its square": (
        text_of(
            "def appear(position, camera, values):  " + HERE + "\n"
            "    return position * (1.0 + values[0]**2)"
        ),
        "no influence to first order",
    ),
    "begins with its root": (
        text_of(
            "def appear(position, camera, values):  " + HERE + "\n"
            "    return position * (1.0 + np.sqrt(np.abs(values[0])))"
        ),
        "has no slope where it is off",
    ),
}


@pytest.mark.parametrize("case", MISBEHAVING)
def test_an_effect_that_misbehaves_is_named_with_the_line_at_fault(
    tmp_path: Path, case: str
) -> None:
    text, named = MISBEHAVING[case]
    found = loaded(tmp_path, text)
    assert found.effects == ()
    [fault] = found.faults
    assert fault.effect == "of-my-own"
    assert named in fault.what
    assert fault.line == line_here(text)


SQUARE = """\
def accelerate(flying, values):  # HERE
    speed = np.linalg.norm(flying.velocity, axis=-1, keepdims=True)
    return -values[0] * speed * flying.velocity, np.zeros_like(flying.spin)"""

BY_SPEED = """\
def wrap(operator, values):  # HERE
    def changed(encounter):
        return operator(replace(encounter, e=encounter.e * (1 + values[0] * encounter.approach)))
    return changed"""

UNITS = [
    (SLOWING.replace("values):", f"values):  {HERE}"), "1/s", "1/m", "s^-1"),
    (SQUARE, "1/m", "m/s^2", "m^-1"),
    (BY_SPEED, "s/m", "m/s", "m^-1 s"),
    (LATE.replace("values):", f"values):  {HERE}"), "s", "m", "s"),
]


@pytest.mark.parametrize(("function", "right", "wrong", "taken"), UNITS)
def test_a_unit_that_the_function_contradicts_is_named_with_the_one_it_takes(
    tmp_path: Path, function: str, right: str, wrong: str, taken: str
) -> None:
    assert loaded(tmp_path, text_of(function, unit=right, more=", step=1e-7")).faults == ()
    text = text_of(function, unit=wrong, more=", step=1e-7")
    [fault] = loaded(tmp_path, text).faults
    assert f"declared in {wrong}, but the function takes it in {taken}" in fault.what
    assert fault.line == line_here(text)


def test_a_unit_is_not_judged_where_numbers_of_the_file_may_carry_one(tmp_path: Path) -> None:
    slow = SLOWING.replace("values[0]", "values[0] * RATE")
    text = text_of(slow, unit="1").replace("\n\n\ndef", "\n\nRATE = 2.0\n\n\ndef", 1)
    assert loaded(tmp_path, text).faults == ()


def test_a_unit_is_not_judged_where_a_column_of_the_shot_list_may_carry_one(tmp_path: Path) -> None:
    warm = BY_SPEED.replace("encounter.approach", "encounter.covariates['temperature_c']")
    assert loaded(tmp_path, text_of(warm, unit="1/K")).faults == ()


def test_a_small_pull_on_positions_is_an_influence(tmp_path: Path) -> None:
    assert loaded(tmp_path, text_of(STRETCH, plausible="(-1e-5, 1e-5)")).faults == ()
