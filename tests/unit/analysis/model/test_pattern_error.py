"""What a learned pattern's own error explains is no finding; what is larger still is one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.model.candidate import Candidate
from analysis.model.fit import fit_campaign
from analysis.model.leaders import refitted
from analysis.model.poses import PoseData
from analysis.model.ranking import rank
from tests.unit.analysis.model.chosen import chosen
from tests.unit.analysis.model.hard_spheres import campaign

EFFECTS = chosen("mass-offset", "image-scale", "drag")
PATTERN_M = 1.2e-5


def off_centre(size_m: float, *, pattern_m: float) -> PoseData:
    """Return spheres whose tracked points stand off their centres, fixed in each body."""
    data = campaign(60, 41)
    offset = size_m * np.array([[0.8, -0.6, 0.0], [0.0, 0.6, 0.8]])
    moved = data.position + (data.rotation @ offset[..., None])[..., 0]
    return replace(data, position=moved, slow_position_m=pattern_m, slow_rotation_rad=1e-7)


def promised(data: PoseData) -> Candidate:
    ranking = rank(data, fit_campaign(data), EFFECTS)
    return next(c for c in ranking.candidates if c.effect.name == "mass-offset")


def test_an_offset_that_the_pattern_may_have_is_no_finding() -> None:
    told = promised(off_centre(1.5e-5, pattern_m=1e-9))
    untold = promised(off_centre(1.5e-5, pattern_m=PATTERN_M))
    assert told.p_familywise < 0.001
    assert told.granted == pytest.approx(1.0, abs=1e-3)
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
    data = replace(off_centre(1.5e-5, pattern_m=PATTERN_M), one_body_frame=False)
    assert data.pattern_m == 0.0
