"""A folder of effects: what is sound is loaded, what is not is named with file and line."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from analysis.collision.operator import walton
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import ContactEffect
from analysis.effects.own.loading import load_effects
from analysis.effects.own.template import template
from analysis.errors import InputError
from tests.unit.analysis.effects.encounters import any_encounters
from tests.unit.analysis.effects.own_files import (
    DRIFT,
    HERE,
    LATE,
    SLOWING,
    STRETCH,
    line_here,
    text_of,
    write,
)

SOUND = [(STRETCH, "1"), (SLOWING, "1/s"), (DRIFT, "1"), (LATE, "s")]


@pytest.mark.parametrize(("function", "unit"), SOUND)
def test_a_sound_effect_of_each_stage_is_loaded(tmp_path: Path, function: str, unit: str) -> None:
    write(tmp_path, text_of(function, unit=unit, more=", step=1e-7"))
    loaded = load_effects(tmp_path, CATALOGUE)
    assert loaded.faults == ()
    assert [effect.name for effect in loaded.effects] == ["of-my-own"]


@pytest.mark.parametrize("stage", ["contact", "flight", "camera", "clock"])
def test_the_file_to_fill_in_works_as_it_stands(tmp_path: Path, stage: str) -> None:
    text = template("of-my-own", stage)
    assert len(text.splitlines()) <= 35
    write(tmp_path, text)
    loaded = load_effects(tmp_path, CATALOGUE)
    assert loaded.faults == ()
    [effect] = loaded.effects
    assert (effect.name, effect.stage) == ("of-my-own", stage)


def test_a_loaded_effect_does_what_its_file_says(tmp_path: Path) -> None:
    write(tmp_path, text_of(DRIFT))
    [effect] = load_effects(tmp_path, CATALOGUE).effects
    assert isinstance(effect, ContactEffect)
    encounter = any_encounters(20)
    plain, changed = walton(encounter), effect.wrap(walton, np.array([0.1]))(encounter)
    relative = [o.after.velocity_b - o.after.velocity_a for o in (plain, changed)]
    ratio = np.divide(*[(v * encounter.normal).sum(axis=1) for v in reversed(relative)])
    assert ratio == pytest.approx(1.0 + 0.1 * encounter.covariates["order"], abs=1e-12)


FAULTY = {
    "is not Python": ("x = 1\ndef f(:  " + HERE, "is not Python"),
    "cannot be imported": ("x = 1\nimport no_such_module  " + HERE, "no_such_module"),
    "fails while it is read": ("def f():\n    1 / 0  " + HERE + "\nf()\n", "ZeroDivisionError"),
    "leaves the program": ("import sys\nsys.exit(3)  " + HERE, "SystemExit: 3"),
    "defines nothing": ("x = 1  " + HERE, "defines no effect"),
    "defines something else": ("x = 1\nEFFECT = 'drag'  " + HERE, "defines no effect"),
    "has a name in another form": (text_of(STRETCH, name="My_own", here=HERE), "'My_own'"),
    "has a name of the catalogue": (text_of(STRETCH, name="drag", here=HERE), "the catalogue"),
    "has an unknown unit": (text_of(STRETCH, unit="furlong", here=HERE), "'furlong'"),
    "has an empty range": (text_of(STRETCH, plausible="(1, 1)", here=HERE), "is empty"),
    "is off out of range": (text_of(STRETCH, plausible="(1, 2)", here=HERE), "off value 0"),
    "has a range without end": (
        text_of(STRETCH, plausible="(0, float('inf'))", here=HERE),
        "no finite number",
    ),
    "has no step": (text_of(STRETCH, more=", step=0", here=HERE), "step is 0"),
    "is one-sided in the middle": (
        text_of(STRETCH, more=", one_sided=True", here=HERE),
        "one-sided",
    ),
    "says nothing": (
        text_of(STRETCH, here=HERE).replace("'f'", "' '"),
        "says nothing as its formula",
    ),
    "has no parameters": (
        text_of(STRETCH, here=HERE).replace("parameters=(", "parameters=() and ("),
        "has no parameters",
    ),
    "has a list for a name": (
        text_of(STRETCH, here=HERE).replace("'of-my-own'", "['of-my-own']"),
        "['of-my-own'] is not in the form",
    ),
    "has words for parameters": (
        text_of(STRETCH, here=HERE).replace("parameters=(", "parameters=('a',) or ("),
        "'a' among its parameters",
    ),
    "shares a symbol": (
        text_of(STRETCH, here=HERE).replace("parameters=(", "parameters=2 * ("),
        "share a symbol",
    ),
    "has nothing for variants": (
        text_of(STRETCH, here=HERE).replace("appear=appear", "appear=appear, variants=None"),
        "variants that are no effects",
    ),
    "is confused with nothing known": (
        text_of(STRETCH, here=HERE).replace("appear=appear", "appear=appear, confused_with=3"),
        "no names",
    ),
    "has no function": (
        text_of(STRETCH, here=HERE).replace("appear=appear", "appear=3"),
        "no function",
    ),
}


@pytest.mark.parametrize("case", FAULTY)
def test_a_file_that_is_of_no_use_is_named_with_its_line(tmp_path: Path, case: str) -> None:
    text, named = FAULTY[case]
    path = write(tmp_path, text)
    loaded = load_effects(tmp_path, CATALOGUE)
    assert loaded.effects == ()
    [fault] = loaded.faults
    assert (fault.path, fault.line) == (path, line_here(text))
    assert named in fault.what
    assert fault.todo
    assert fault.sentence().startswith(f"{path}, line {fault.line}: {fault.effect}: ")
    assert "\n" not in fault.sentence()


def test_faults_of_some_leave_the_others(tmp_path: Path) -> None:
    write(tmp_path, text_of(STRETCH, name="first"), "a")
    write(tmp_path, "1 / 0", "b")
    write(tmp_path, text_of(DRIFT, name="last"), "c")
    write(tmp_path, text_of(DRIFT, name="first"), "d")
    loaded = load_effects(tmp_path, CATALOGUE)
    assert [effect.name for effect in loaded.effects] == ["first", "last"]
    assert [fault.path.name for fault in loaded.faults] == ["b.py", "d.py"]
    assert "a.py" in loaded.faults[1].what


def test_a_file_is_read_afresh_and_leaves_nothing_beside_it(tmp_path: Path) -> None:
    path = write(tmp_path, text_of(STRETCH, name="before"))
    load_effects(tmp_path, CATALOGUE)
    when = path.stat()
    path.write_text(text_of(STRETCH, name="after1"), encoding="utf-8")
    os.utime(path, ns=(when.st_atime_ns, when.st_mtime_ns))
    assert [e.name for e in load_effects(tmp_path, CATALOGUE).effects] == ["after1"]
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_what_a_file_prints_stays_off_standard_output(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path, text_of(STRETCH) + "print('hello')\n")
    assert load_effects(tmp_path, CATALOGUE).faults == ()
    assert capsys.readouterr() == ("", "hello\n")


@pytest.mark.parametrize("there", [True, False])
def test_a_folder_without_effects_is_refused(tmp_path: Path, there: bool) -> None:
    folder = tmp_path if there else tmp_path / "nowhere"
    with pytest.raises(InputError) as raised:
        load_effects(folder, CATALOGUE)
    assert raised.value.path == str(folder)
