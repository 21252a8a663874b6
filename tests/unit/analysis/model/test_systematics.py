"""What an error of the measurement explains is no finding; what is larger still is one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.arrays import Floats
from analysis.model.agreement.agree import agree
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.rank.candidate import Candidate
from analysis.model.rank.leaders import refitted
from analysis.model.rank.ranking import rank
from analysis.setup import SlowErrors
from tests.unit.analysis.model.chosen import chosen
from tests.unit.analysis.model.hard_spheres import campaign

EFFECTS = chosen("mass-offset", "image-scale", "radius-mismatch", "drag")
PATTERN_M = 1.2e-5
OUTLINE_M = 8e-6 * np.array([0.0, 1.0, 0.0])


def off_centre(size_m: float, *, pattern_m: float) -> PoseData:
    """Return spheres whose tracked points stand off their centres, fixed in each body."""
    data = campaign(60, 41)
    offset = size_m * np.array([[0.8, -0.6, 0.0], [0.0, 0.6, 0.8]])
    moved = data.position + (data.rotation @ offset[..., None])[..., 0]
    return replace(data, position=moved, slow=SlowErrors(pattern_m, 1e-7))


def beside(offset: Floats, *, slow_m: float) -> PoseData:
    """Return spheres of which b is always seen beside where it is."""
    data = campaign(60, 42)
    moved = data.position + np.stack([np.zeros(3), offset])
    return replace(data, position=moved, slow=SlowErrors(slow_m, 1e-7))


def enlarged(share: float, *, told: float) -> PoseData:
    """Return spheres of which all lengths are seen too long by a share."""
    data = campaign(60, 43)
    return replace(data, position=(1.0 + share) * data.position, slow=SlowErrors(scale=told))


def promised(data: PoseData, name: str) -> Candidate:
    ranking = rank(data, fit_campaign(data), EFFECTS)
    return next(c for c in ranking.candidates if c.effect.name == name)


def test_an_offset_that_the_pattern_may_have_is_no_finding() -> None:
    told = promised(off_centre(1.5e-5, pattern_m=1e-9), "mass-offset")
    untold = promised(off_centre(1.5e-5, pattern_m=PATTERN_M), "mass-offset")
    assert told.p_familywise < 0.001
    assert untold.p_familywise > 0.05
    # Two spheres, each 15 um in some direction, against 12 um in each of three.
    assert untold.fall < 2 * (1.5e-5 / PATTERN_M) ** 2 + 6


def test_a_centre_of_mass_far_beyond_the_pattern_is_found_all_the_same() -> None:
    data = off_centre(1.5e-4, pattern_m=PATTERN_M)
    fit = fit_campaign(data)
    ranking = rank(data, fit, EFFECTS)
    first = ranking.candidates[0]
    assert first.effect.name == "mass-offset"
    assert first.p_familywise < 0.001
    assert refitted(data, fit, ranking, 0.03)[0].fall < fit.chi2


def test_without_a_common_body_frame_there_is_no_pattern_to_blame() -> None:
    data = off_centre(1.5e-5, pattern_m=PATTERN_M)
    data = replace(data, slow=replace(data.slow, one_body_frame=False))
    assert [s.effect.name for s in data.systematics] == ["outline-offset"]


def test_outlines_that_are_seen_beside_their_spheres_are_no_other_radius() -> None:
    trusted = promised(beside(OUTLINE_M, slow_m=1e-9), "radius-mismatch")
    granted = promised(beside(OUTLINE_M, slow_m=6e-6), "radius-mismatch")
    assert trusted.p_familywise < 0.001
    assert granted.p_familywise > 0.05


def test_a_scale_as_wrong_as_it_may_be_is_no_finding() -> None:
    trusted = promised(enlarged(1e-3, told=0.0), "image-scale")
    granted = promised(enlarged(1e-3, told=1e-3), "image-scale")
    assert trusted.p_familywise < 0.001
    assert granted.p_familywise > 0.05


def test_a_scale_far_beyond_its_error_is_found_all_the_same() -> None:
    assert promised(enlarged(8e-3, told=1e-3), "image-scale").p_familywise < 0.001


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
