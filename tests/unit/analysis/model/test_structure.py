"""Every shot's residual behind a cell of the heat map, and how the residuals run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from analysis.model.structure.lackoffit import lack_of_fit
from analysis.model.structure.layout import covariate_label
from analysis.model.structure.structure import Structure, running_mean, structure
from tests.unit.analysis.model.hard_spheres import campaign

SHOTS = 40


@pytest.fixture(scope="module")
def data() -> PoseData:
    quiet = campaign(SHOTS, 71)
    warm = np.random.default_rng(71).uniform(18, 27, SHOTS)
    covariates = {**quiet.covariates, "temperature_c": warm}
    return replace(quiet, shots=quiet.shots + 100, covariates=covariates)


@pytest.fixture(scope="module")
def quiet(data: PoseData) -> Structure:
    return structure(data, fit_campaign(data))


def test_the_cells_are_those_of_the_test_for_lack_of_fit(data: PoseData, quiet: Structure) -> None:
    assert quiet.cells == lack_of_fit(data, fit_campaign(data))


def test_a_column_of_the_shot_list_is_a_covariate(quiet: Structure) -> None:
    found = quiet.residuals("relative velocity n", "temperature_c")
    assert found.unit == "mm/s"
    assert found.place.min() > 18
    assert list(found.shots) == list(range(101, 101 + SHOTS))
    assert (found.frames == -1).all()


def test_residuals_of_shots_scatter_as_their_errors_say(quiet: Structure) -> None:
    for channel, (residual, sigma) in quiet.jumps.items():
        square = float(((residual / sigma) ** 2).mean())
        assert square == pytest.approx(1, abs=4 * np.sqrt(2 / SHOTS)), channel


def test_a_shot_that_leaves_too_fast_says_so_in_its_unit(data: PoseData) -> None:
    fit = fit_campaign(data)
    tau = np.maximum(data.times_s - fit.states.time_s[:, None], 0)[..., None]
    excess = np.where(np.arange(SHOTS) % 2, 30.0, -30.0)
    push = 1e-3 * excess[:, None, None] * tau * fit.states.normal[:, None] / 2
    moved = replace(data, position=data.position + np.stack([-push, push], axis=2))
    found = structure(moved, fit_campaign(moved)).residuals("relative velocity n", "order")
    assert np.abs((found.residual - excess) / found.sigma).max() < 5


def test_frames_are_named_by_shot_and_place_in_it(quiet: Structure) -> None:
    flight = quiet.residuals("relative position n", "time")
    camera = quiet.residuals("image X", "field Y")
    assert (flight.unit, camera.unit) == ("mm", "mm")
    assert len(flight.place) == SHOTS * 24
    assert len(camera.place) == 2 * SHOTS * 24
    assert set(flight.shots) == set(range(101, 101 + SHOTS))
    assert set(flight.frames) == set(range(24))


def test_the_curve_of_a_bent_field_is_what_bends_it(data: PoseData) -> None:
    position = data.position.copy()
    position[..., 1] += 5e-4 * (position[..., 1] / 0.05) ** 3
    bent = replace(data, position=position)
    trend = structure(bent, fit_campaign(bent)).residuals("image Y", "field Y").trend
    wanted = 0.5 * (trend.place / 0.05) ** 3
    # A stretch of the field is taken for speed: only what is not straight can be told.
    rest = trend.mean - wanted
    crooked = rest - np.polyval(np.polyfit(trend.place, rest, 1), trend.place)
    assert np.abs(crooked).max() < 0.2 * np.ptp(wanted)
    assert (trend.sigma > 0).all()


def test_a_cell_that_is_not_there_is_refused(quiet: Structure) -> None:
    with pytest.raises(KeyError, match="no cell of image X against time"):
        quiet.residuals("image X", "time")


def test_a_running_mean_follows_a_line_with_the_error_of_a_weighted_mean() -> None:
    place = np.linspace(0.0, 10.0, 2001)
    trend = running_mean(place, 3 * place - 1, np.full(place.shape, 0.2))
    inner = (trend.place > 4.5) & (trend.place < 5.5)
    np.testing.assert_allclose(trend.mean[inner], (3 * trend.place - 1)[inner], atol=1e-5)
    # A Gaussian window of width w over n points a unit counts 2 sqrt(pi) w n of them.
    width = 0.08 * (trend.place[-1] - trend.place[0])
    np.testing.assert_allclose(
        trend.sigma[inner], 0.2 / np.sqrt(2 * np.sqrt(np.pi) * width * 200.0), rtol=1e-3
    )


def test_nothing_runs_where_all_places_are_one() -> None:
    assert running_mean(np.ones(5), np.arange(5.0), np.ones(5)).place.size == 0


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("offset_mm", "offset, mm"),
        ("pressure_a_kpa", "pressure a, kPa"),
        ("temperature_c", "temperature, °C"),
        ("humidity", "humidity"),
        ("time", "time from contact, s"),
    ],
)
def test_a_covariate_is_labelled_with_its_unit(name: str, label: str) -> None:
    assert covariate_label(name) == label
