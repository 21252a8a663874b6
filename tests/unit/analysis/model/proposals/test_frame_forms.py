"""Pictures that err with the place and frames that err with the time are told from the contact."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.own.loading import load_effects
from analysis.model.data.poses import PoseData
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.proposals.effect_file import written
from analysis.model.proposals.propose import propose
from tests.unit.analysis.model.proposals.hidden import campaign


def bent(data: PoseData) -> PoseData:
    """Return the data with rows that lean over with the square of the column."""
    position = data.position.copy()
    position[..., 0] += 0.3 * position[..., 1] ** 2
    return replace(data, position=position)


def fluttering(data: PoseData) -> PoseData:
    """Return the data with frames that come early and late 113 times a second."""
    times = data.times_s
    return replace(data, times_s=times - 2e-5 * np.sin(2 * np.pi * 113.0 * times))


def slowing(data: PoseData) -> PoseData:
    """Return the data of a tape that slows down in the course of a shot."""
    return replace(data, times_s=data.times_s - 0.06 * data.times_s**2)


@pytest.mark.parametrize(
    ("treat", "group", "shape", "true"),
    [
        (bent, ("camera", "contact_y"), "power", {"a": 0.3}),
        (fluttering, ("clock", "time"), "periodic", {"a": 2e-5, "b": 0.0, "f": 113.0}),
        pytest.param(*(slowing, ("clock", "time"), "power", {"a": 0.06}), marks=pytest.mark.long),
    ],
    ids=["bent", "fluttering", "slowing"],
)
def test_an_error_of_camera_or_clock_is_proposed_with_its_constants_and_as_a_file(
    tmp_path: Path,
    treat: object,
    group: tuple[str, str],
    shape: str,
    true: dict[str, float],
) -> None:
    assert callable(treat)
    data = treat(campaign({}, 5))
    found = propose(data, (), CATALOGUE)
    [only] = found.accepted
    assert (only.form.group, only.form.shape_name) == (group, shape)
    constants = only.freed.parameters()
    for name, value in true.items():
        own = constants[f"{only.name}.{name}"]
        assert abs(own.value - value) < 4 * own.sigma + 0.01 * abs(value)
    written(tmp_path, "x", found)
    loaded = load_effects(tmp_path, CATALOGUE)
    assert loaded.faults == ()
    again = robust_fit(data, loaded.effects).fit
    assert again.chi2 == pytest.approx(found.fit.chi2, abs=0.1)
