"""An effect that fails on the data of a campaign is named; everything else goes on without it."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import analysis.effects
from analysis.collision.operator import Encounter, Outcome, walton
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import CameraEffect, ContactEffect, ContactLaw, Effect
from analysis.effects.own.dropping import without_faulty
from analysis.effects.own.fault import EffectFault
from analysis.effects.own.guard import FUNCTIONS
from analysis.effects.own.loading import load_effects
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.rank.ranking import rank
from analysis.model.verdict.selection import explain
from analysis.setup import CameraSetup
from tests.unit.analysis.effects.encounters import any_encounters
from tests.unit.analysis.effects.own_files import DRIFT, HERE, STRETCH, line_here, text_of, write
from tests.unit.analysis.model.hard_spheres import CAMERA, campaign

COLUMN = """\
def wrap(operator, values):
    def changed(encounter):
        warmth = encounter.covariates["warmth"]  # HERE
        return operator(replace(encounter, e=encounter.e * (1 + values[0] * warmth)))
    return changed"""

CROWD = """\
def appear(position, camera, values):
    if len(position) == 8:
        raise RuntimeError("eight shots\\nare too many")  # HERE
    return position * (1.0 + values[0])"""

HOLES = """\
def appear(position, camera, values):  # HERE
    hole = np.nan if len(position) == 8 else 0.0
    return position * (1.0 + values[0]) + hole"""

FAILING = [
    (COLUMN, "not every shot has a column warmth; all have order"),
    (CROWD, "raised RuntimeError: eight shots are too many"),
    (HOLES, "returned position that is not finite at a = "),
]

FEW = tuple(effect for effect in CATALOGUE if effect.name in {"image-scale", "drag"})


@cache
def fitted() -> tuple[PoseData, Fit]:
    data = campaign(8, 3)
    return data, fit_campaign(data)


def own(folder: Path, function: str) -> Effect:
    write(folder, text_of(function))
    [effect] = load_effects(folder, CATALOGUE).effects
    return effect


@pytest.mark.parametrize(("function", "named"), FAILING)
def test_the_others_are_ranked_as_if_it_were_not_there(
    tmp_path: Path, function: str, named: str
) -> None:
    data, fit = fitted()
    effects = (own(tmp_path, function), *FEW)
    ranking, [fault] = without_faulty(effects, lambda left: rank(data, fit, left))
    alone = rank(data, fit, FEW)
    assert [c.effect.name for c in ranking.candidates] == [c.effect.name for c in alone.candidates]
    assert [c.delta_chi2 for c in ranking.candidates] == [c.delta_chi2 for c in alone.candidates]
    assert named in fault.what
    assert fault.line == line_here(text_of(function))


def test_an_effect_of_ones_own_is_ranked_like_the_same_of_the_catalogue(tmp_path: Path) -> None:
    data, fit = fitted()
    mine = own(tmp_path, STRETCH)
    ranking, faults = without_faulty((mine, *FEW), lambda left: rank(data, fit, left))
    assert faults == ()
    scores = {c.effect.name: c.score for c in ranking.candidates}
    assert scores["of-my-own"] == pytest.approx(scores["image-scale"], rel=1e-9)


LATE_FALL = """\
def appear(position, camera, values):
    if abs(values[0]) > 1e-3 and len(position) > 16:
        raise ArithmeticError("too far")  # HERE
    return position * (1.0 + values[0])"""


def test_a_fault_that_only_a_refit_brings_leaves_the_verdict_to_the_others(tmp_path: Path) -> None:
    data = campaign(20, 91)
    stretched = replace(data, position=1.004 * data.position)
    effects = (own(tmp_path, LATE_FALL), *FEW)
    verdict, [fault] = without_faulty(effects, lambda left: explain(stretched, left))
    assert verdict.effects == ("image-scale",)
    assert "ArithmeticError: too far" in fault.what
    assert fault.line == line_here(text_of(LATE_FALL))


def test_a_fault_in_a_fit_that_needs_the_effect_is_raised(tmp_path: Path) -> None:
    data, fit = fitted()
    mine = own(tmp_path, CROWD)
    with pytest.raises(EffectFault, match="of-my-own: raised RuntimeError"):
        without_faulty(FEW, lambda _: fit_campaign(data, fit.theory.with_effect(mine), fit))


ROOMS = Path(analysis.effects.__file__).parent


def source_of(effect: Effect) -> str:
    """Return the text of the file that defines an effect of the catalogue."""
    [file] = ROOMS.rglob(f"{effect.name.replace('-', '_')}.py")
    return file.read_text(encoding="utf-8")


def appearing(
    effect: Effect, position: np.ndarray, camera: CameraSetup, value: float
) -> np.ndarray:
    assert isinstance(effect, CameraEffect)
    return effect.appear(position, camera, np.array([value]))


ROOT = f"""\
def appear(position, camera, values):  {HERE}
    return position * np.sqrt(1.0 + values[0])"""


def test_nan_beyond_the_plausible_range_is_an_answer_and_no_fault(tmp_path: Path) -> None:
    effect = own(tmp_path, ROOT)
    position = np.ones((4, 2, 2, 3))
    assert np.isnan(appearing(effect, position, CAMERA, -1.5)).all()


def test_what_is_not_finite_before_is_no_fault_of_the_effect(tmp_path: Path) -> None:
    effect = own(tmp_path, ROOT)
    lost = np.full((4, 2, 2, 3), np.nan)
    assert np.isnan(appearing(effect, lost, CAMERA, 0.01)).all()


def test_what_another_effect_leaves_that_is_not_finite_is_no_fault_of_the_effect(
    tmp_path: Path,
) -> None:
    def lost(encounter: Encounter) -> Outcome:
        return replace(walton(encounter), duration=np.full(len(encounter.e), np.nan))

    effect = own(tmp_path, DRIFT)
    assert isinstance(effect, ContactEffect)
    assert np.isnan(effect.wrap(lost, np.array([0.01]))(any_encounters(5)).duration).all()


def test_a_fault_crosses_to_another_process_whole(tmp_path: Path) -> None:
    effect = own(tmp_path, CROWD)
    with pytest.raises(EffectFault) as raised:
        appearing(effect, np.ones((8, 2, 2, 3)), CAMERA, 0.0)
    assert pickle.loads(pickle.dumps(raised.value)).fault == raised.value.fault
    assert str(raised.value) == raised.value.fault.sentence()


def test_every_file_of_the_catalogue_handed_in_as_ones_own_scores_the_same(tmp_path: Path) -> None:
    stages = [e for e in CATALOGUE if e.stage in FUNCTIONS and not isinstance(e, ContactLaw)]
    sources = {effect.name: source_of(effect) for effect in stages}
    for name, text in sources.items():
        write(tmp_path, text.replace(f'name="{name}"', f'name="my-{name}"'), f"my-{name}")
    loaded = load_effects(tmp_path, CATALOGUE)
    assert loaded.faults == ()
    data, fit = fitted()
    scores = {c.effect.name: c.score for c in rank(data, fit, stages).candidates}
    mine = {c.effect.name: c.score for c in rank(data, fit, loaded.effects).candidates}
    assert mine == {f"my-{name}": pytest.approx(score) for name, score in scores.items()}
