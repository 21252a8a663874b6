"""The verdict: nothing, the effect that is there, several that look alike, or none that is known.

Strengths are eight standard errors of what 40 such shots can see, but where more is said.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.effects.effect import CameraEffect, Effect
from analysis.model.data.poses import PoseData
from analysis.model.verdict.selection import UNEXPLAINED_LEVEL, Verdict, explain
from analysis.setup import CameraSetup
from tests.unit.analysis.model.chosen import EFFECTS, WIDELY_BELIEVED, believed_up_to, chosen
from tests.unit.analysis.model.hard_spheres import Hidden, campaign

SHOTS = 40


def stretched(data: PoseData, along: tuple[float, float, float]) -> PoseData:
    return replace(data, position=data.position * (1 + np.array(along)))


def at_slow_clock(data: PoseData, share: float) -> PoseData:
    """Return the data with frames further apart than is stated."""
    return replace(data, times_s=data.times_s / (1 + share))


HIDDEN = {
    "image-scale": lambda: stretched(campaign(SHOTS, 71), (6e-4, 6e-4, 6e-4)),
    "restitution-viscoelastic": lambda: campaign(SHOTS, 72, hidden=Hidden(slope=5e-3)),
    "gravity-direction": lambda: tilted(campaign(SHOTS, 73), 0.018),
}


def tilted(data: PoseData, angle: float) -> PoseData:
    position, tau = data.position.copy(), data.times_s - data.times_s.mean()
    position[..., 1] += (0.5 * 9.80665 * np.sin(angle) * tau**2)[..., None]
    return replace(data, position=position)


@pytest.fixture(scope="module", params=HIDDEN)
def named(request: pytest.FixtureRequest) -> tuple[str, Verdict]:
    return request.param, explain(HIDDEN[request.param](), EFFECTS)


def test_the_effect_that_is_there_is_named(named: tuple[str, Verdict]) -> None:
    true, verdict = named
    assert verdict.verdict in {"effect", "alias"}
    assert true in verdict.alias_set
    assert len(verdict.effects) == 1


def test_the_path_begins_at_the_base_model_and_its_errors_fall(
    named: tuple[str, Verdict],
) -> None:
    _, verdict = named
    assert verdict.path[0].effects == ()
    assert verdict.path[-1].effects == verdict.effects
    errors = [stage.error.value for stage in verdict.path]
    assert errors == sorted(errors, reverse=True)
    assert len(set(errors)) == len(errors)
    assert verdict.path[-1].fit.chi2 < verdict.path[0].fit.chi2 - 30


def test_the_effect_is_named_by_itself_where_nothing_else_looks_like_it() -> None:
    verdict = explain(stretched(campaign(SHOTS, 71), (2e-3, 2e-3, 2e-3)), EFFECTS)
    assert (verdict.verdict, verdict.effects) == ("effect", ("image-scale",))
    found = verdict.fit.parameters()["image-scale.s"]
    assert found.value == pytest.approx(2e-3, abs=4 * found.sigma)


@pytest.mark.long
def test_nothing_is_claimed_when_nothing_is_missing() -> None:
    verdicts = [explain(campaign(20, 740 + seed), EFFECTS) for seed in range(5)]
    # Each claims something with a chance of 0.03: two or more of five in 0.8 per cent of all cases.
    assert sum(verdict.verdict != "none" for verdict in verdicts) <= 1
    quiet = next(verdict for verdict in verdicts if verdict.verdict == "none")
    assert quiet.effects == ()
    assert quiet.alias_set == ()
    assert len(quiet.path) == 1


def test_a_slow_clock_and_a_stronger_gravity_are_not_told_apart() -> None:
    verdict = explain(at_slow_clock(campaign(SHOTS, 75), 0.01), WIDELY_BELIEVED)
    assert verdict.verdict == "alias"
    assert {"frame-rate", "gravity-value"} <= set(verdict.alias_set)


def test_the_alias_set_is_that_of_the_effect_that_has_company() -> None:
    data = at_slow_clock(stretched(campaign(SHOTS, 76), (4e-3, 4e-3, 4e-3)), 0.012)
    verdict = explain(data, widely("image-scale", "frame-rate", "gravity-value"))
    assert verdict.effects[0] == "image-scale"
    assert verdict.verdict == "alias"
    assert set(verdict.alias_set) == {"frame-rate", "gravity-value"}
    assert verdict.alias_sets["image-scale"] == ("image-scale",)


def widely(*names: str) -> tuple[Effect, ...]:
    return tuple(effect for effect in WIDELY_BELIEVED if effect.name in names)


def test_an_attraction_in_flight_is_unexplained() -> None:
    verdict = explain(campaign(SHOTS, 77, hidden=Hidden(pull=60.0)), EFFECTS)
    assert verdict.verdict == "unexplained"
    assert verdict.cells[0].p_holm < UNEXPLAINED_LEVEL


def _wider(position: np.ndarray, camera: CameraSetup, values: np.ndarray) -> np.ndarray:
    del camera
    return position * np.array([1.0, 1.0 + values[0], 1.0])


def believed_within(effect: Effect, low: float, high: float) -> Effect:
    [parameter] = effect.parameters
    return replace(effect, parameters=(replace(parameter, plausible=(low, high)),))


[SCALE] = chosen("image-scale")
WIDER = CameraEffect(
    name="wider",
    title="Stretch along Y",
    parameters=SCALE.parameters,
    formula="y' = (1 + s) y",
    source="made for this test",
    gives_away="Y alone",
    appear=_wider,
)


def test_a_plausible_effect_goes_before_a_better_one_that_is_not_believed() -> None:
    data = stretched(campaign(SHOTS, 78), (3e-3, 3e-3, 3e-3))
    doubted = believed_within(SCALE, -1e-5, 1e-5)
    assert explain(data, (SCALE, WIDER)).path[1].effects == ("image-scale",)
    assert explain(data, (doubted, WIDER)).path[1].effects == ("wider",)


def test_an_effect_that_is_not_believed_is_in_no_verdict_but_leads_the_candidates() -> None:
    data = stretched(campaign(SHOTS, 78), (3e-3, 3e-3, 3e-3))
    verdict = explain(data, (believed_up_to(SCALE, 1e-5), *chosen("drag")))
    assert verdict.verdict == "unexplained"
    assert "image-scale" not in verdict.effects
    assert verdict.first_ranking.candidates[0].effect.name == "image-scale"


def test_progress_is_told_step_by_step() -> None:
    said: list[str] = []
    explain(campaign(6, 79), EFFECTS, said.append)
    assert said[0] == "fitting the base model"
    assert said[-1] == "testing what is left"


def test_two_effects_whose_marks_add_up_to_those_of_a_force_are_not_believed() -> None:
    data = campaign(SHOTS, 860, hidden=Hidden(pull=6.0))
    pair = chosen("image-scale", "restitution-viscoelastic")
    verdict = explain(data, pair)
    assert verdict.verdict == "unexplained"
    assert (verdict.cells[0].channel, verdict.cells[0].covariate) == (
        "relative position n",
        "time",
    )


def test_two_effects_that_are_there_are_believed() -> None:
    data = at_slow_clock(stretched(campaign(SHOTS, 871), (2e-3, 2e-3, 2e-3)), 0.02)
    verdict = explain(data, widely("image-scale", "frame-rate"))
    assert (verdict.verdict, set(verdict.effects)) == ("effect", {"image-scale", "frame-rate"})
