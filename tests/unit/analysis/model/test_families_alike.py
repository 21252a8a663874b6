"""What so few frames leave open between families of a contact that lasts is in its errors."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from analysis.effects.contact.lasting_contact import EFFECT
from analysis.model.data.poses import PoseData
from analysis.model.fitting.robust_fit import robust_fit
from analysis.quantity import Quantity
from benchmarks.discovery.lasting import PLAIN, RIG, STATED_DRAG, lasting_campaign

FRAMES = 24
RATIO = "lasting-contact.kappa"


@cache
def poses(seed: int) -> PoseData:
    return lasting_campaign(replace(PLAIN, drag_coefficient=STATED_DRAG), seed, 36)


def ratio_of(seed: int, frames: int) -> Quantity:
    """Return kt/kn as fitted to so many frames about the contact."""
    data, first = poses(seed), (FRAMES - frames) // 2
    some = slice(first, first + frames)
    few = replace(
        data,
        times_s=data.times_s[:, some],
        position=data.position[:, some],
        position_sigma=data.position_sigma[:, some],
        rotation=data.rotation[:, some],
        rotation_sigma=data.rotation_sigma[:, some],
    )
    return robust_fit(few, [EFFECT]).fit.parameters()[RATIO]


@pytest.mark.parametrize("seed", [703, 711])
def test_the_error_of_the_stiffness_ratio_holds_the_families_that_six_frames_leave(
    seed: int,
) -> None:
    found = ratio_of(seed, 6)
    assert abs(found.value - RIG.stiffness_ratio) < 3.0 * found.sigma
