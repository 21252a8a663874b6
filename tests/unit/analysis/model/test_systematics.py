"""What an error of the measurement explains is no finding; what is larger still is one.

None of these errors changes with the place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.arrays import Floats
from analysis.model.agreement.agree import agree
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.fitting.nuisance import alarms_of
from analysis.model.rank.candidate import Candidate
from analysis.model.rank.leaders import refitted
from analysis.model.rank.ranking import rank
from analysis.model.structure.alarm import alarms
from analysis.model.structure.lackoffit import Cell, lack_of_fit
from analysis.setup import SlowErrors
from tests.unit.analysis.model.chosen import chosen
from tests.unit.analysis.model.hard_spheres import campaign

TURN_RAD = 3e-3 * np.array([[0.0, 0.8, -0.6], [0.6, -0.8, 0.0]])
EFFECTS = chosen("mass-offset", "image-scale", "radius-mismatch", "drag", "gravity-value")
PATTERN_M = 1.2e-5
OUTLINE_M = 8e-6 * np.array([0.0, 1.0, 0.0])


def off_centre(size_m: float, *, pattern_m: float) -> PoseData:
    """Return spheres whose tracked points stand off their centres, fixed in each body."""
    data = campaign(60, 41)
    offset = size_m * np.array([[0.8, -0.6, 0.0], [0.0, 0.6, 0.8]])
    moved = data.position + (data.rotation @ offset[..., None])[..., 0]
    return replace(data, position=moved, slow=SlowErrors(pattern_m, 1e-7, varying=0.0))


def beside(offset: Floats, *, slow_m: float) -> PoseData:
    """Return spheres of which b is always seen beside where it is."""
    data = campaign(60, 42)
    moved = data.position + np.stack([np.zeros(3), offset])
    return replace(data, position=moved, slow=SlowErrors(slow_m, 1e-7, varying=0.0))


def enlarged(share: float, *, told: float) -> PoseData:
    """Return spheres of which all lengths are seen too long by a share."""
    data = campaign(60, 43)
    return replace(data, position=(1.0 + share) * data.position, slow=SlowErrors(scale=told))


def measured_by_diameters(share: float, *, told: float) -> PoseData:
    """Return spheres whose diameters are stated too large by a share, and all lengths with them."""
    data = campaign(60, 45, position_sigma=1e-6, rotation_sigma=5e-4)
    a, b = (replace(body, radius=(1.0 + share) * body.radius) for body in data.bodies)
    position = (1.0 + share) * data.position
    return replace(data, position=position, bodies=(a, b), length_sigma=told)


def turned(*, slow_rad: float) -> PoseData:
    """Return spheres whose orientations are all seen turned about axes of the rig, each by its own.

    Their places and times are as exact as films have them, so that small turns show.
    """
    data = campaign(60, 44, position_sigma=1e-6, rotation_sigma=5e-4)
    seen = Rotation.from_rotvec(TURN_RAD).as_matrix()
    return replace(
        data, rotation=seen @ data.rotation, slow=SlowErrors(rotation_rad=slow_rad, varying=0.0)
    )


def of_spins(data: PoseData) -> list[Cell]:
    cells = lack_of_fit(data, fit_campaign(data))
    return [c for c in cells if "spin" in c.channel and alarms(c, len(data.shots))]


def promised(data: PoseData, name: str) -> Candidate:
    ranking = rank(data, fit_campaign(data), EFFECTS)
    return next(c for c in ranking.candidates if c.effect.name == name)


def test_an_offset_that_the_pattern_may_have_is_no_finding() -> None:
    told = promised(off_centre(1.5e-5, pattern_m=1e-9), "mass-offset")
    untold = promised(off_centre(1.5e-5, pattern_m=PATTERN_M), "mass-offset")
    assert told.p_familywise < 0.001
    assert untold.p_familywise > 0.05
    # Two spheres, each 15 um in some direction, against 12 um in each of three.
    assert untold.delta_chi2 < 2 * (1.5e-5 / PATTERN_M) ** 2 + 6


def test_a_centre_of_mass_far_beyond_the_pattern_is_found_all_the_same() -> None:
    data = off_centre(1.5e-4, pattern_m=PATTERN_M)
    fit = fit_campaign(data)
    ranking = rank(data, fit, EFFECTS)
    first = ranking.candidates[0]
    assert first.effect.name == "mass-offset"
    assert first.p_familywise < 0.001
    assert refitted(data, fit, ranking, 0.03)[0].delta_chi2 < fit.chi2


def test_without_a_common_body_frame_there_is_no_pattern_to_blame() -> None:
    data = off_centre(1.5e-5, pattern_m=PATTERN_M)
    data = replace(data, slow=replace(data.slow, one_body_frame=False))
    assert [s.effect.name for s in data.systematics] == ["outline-offset", "orientation-offset"]


def test_outlines_that_are_seen_beside_their_spheres_are_no_other_radius() -> None:
    trusted = promised(beside(OUTLINE_M, slow_m=1e-9), "radius-mismatch")
    granted = promised(beside(OUTLINE_M, slow_m=6e-6), "radius-mismatch")
    assert trusted.p_familywise < 0.001
    assert granted.p_familywise > 0.05


def test_orientations_that_are_seen_turned_alike_in_all_shots_are_no_spin_of_the_contact() -> None:
    assert of_spins(turned(slow_rad=0.0))
    granted = turned(slow_rad=3e-3)
    assert not of_spins(granted)
    found = fit_campaign(granted).systematics()
    for sphere, truth in zip("ab", TURN_RAD, strict=True):
        for axis, turn in zip("xyz", truth, strict=True):
            one = found[f"orientation-offset.r_{sphere}{axis}"]
            assert one.value == pytest.approx(turn, abs=3.5 * one.sigma)
            assert one.sigma < 1.5e-3


def test_turns_far_beyond_what_is_granted_are_an_alarm() -> None:
    fit = fit_campaign(turned(slow_rad=1e-4))
    assert {one.name.split(".")[0] for one in alarms_of(fit)} == {"orientation-offset"}


def test_a_scale_as_wrong_as_it_may_be_is_no_finding() -> None:
    trusted = promised(enlarged(1e-3, told=0.0), "image-scale")
    granted = promised(enlarged(1e-3, told=1e-3), "image-scale")
    assert trusted.p_familywise < 0.001
    assert granted.p_familywise > 0.05


def test_a_scale_far_beyond_its_error_is_found_all_the_same() -> None:
    assert promised(enlarged(8e-3, told=1e-3), "image-scale").p_familywise < 0.001


def test_diameters_that_are_off_are_seen_in_the_fall_and_are_no_finding() -> None:
    trusted, granted = (measured_by_diameters(1e-3, told=told) for told in (0.0, 1e-3))
    assert promised(trusted, "gravity-value").p_familywise < 0.001
    assert promised(granted, "gravity-value").p_familywise > 0.05
    fit = fit_campaign(granted)
    seen = fit.systematics()["gravity-value.dg"]
    assert seen.sigma < 0.3 * 1e-3 * granted.gravity
    assert seen.value == pytest.approx(1e-3 * granted.gravity, abs=3 * seen.sigma)
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit.freedom))


def test_what_is_found_of_an_outline_is_said_with_its_error_and_apart_from_the_law() -> None:
    data = beside(OUTLINE_M, slow_m=6e-6)
    fit = fit_campaign(data)
    found = fit.systematics()["outline-offset.d_y"]
    assert found.value == pytest.approx(OUTLINE_M[1], abs=3 * found.sigma)
    assert found.sigma < 3e-6
    assert list(fit.parameters()) == ["e", "mu", "beta0"]


def test_a_stated_error_that_is_there_leaves_chi_squared_at_its_freedom() -> None:
    fit = fit_campaign(beside(OUTLINE_M, slow_m=6e-6))
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit.freedom))


def test_what_is_granted_leaves_no_stage_in_disagreement() -> None:
    data = beside(OUTLINE_M, slow_m=6e-6)
    rows = [row for stage in agree(data, fit_campaign(data)).stages for row in stage.rows]
    assert min(row.p_value for row in rows) > 0.001
