"""Results of whole campaigns against the truth of simulators that share no code with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from analysis.collision.operator import WaltonLaw
from analysis.effects.contact.tangential_compliance import maw_curve, walton_curve
from analysis.model.data.gather import gather
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import fit_campaign
from analysis.results.campaign import Results, results
from analysis.results.drawing import plane_figure, residual_figure, restitution_figure
from analysis.results.lines import Lines
from analysis.results.tables import tables
from simulators.challenge.making import write_challenge
from tests.unit.analysis.model.tabulated import impacts as scalar_folder

NYLON = {"e": 0.74, "mu": 0.08, "beta0": 0.5}
CAMPAIGNS, SHOTS = 4, 24


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory: pytest.TempPathFactory) -> list[Results]:
    found = []
    for seed in range(CAMPAIGNS):
        folder = tmp_path_factory.mktemp("hidden") / "nylon"
        write_challenge(folder, {}, seed, SHOTS)
        found.append(results(gather(folder)[1]))
    return found


def pull(lines: Lines, name: str) -> float:
    place = lines.fitted.index(name)
    sigma = np.sqrt(lines.covariance[place, place])
    return float((getattr(lines.law, name) - NYLON[name]) / sigma)


def test_the_regression_finds_the_law_of_the_simulator(campaigns: list[Results]) -> None:
    for name in NYLON:
        pulls = np.array([pull(one.lines, name) for one in campaigns if name in one.lines.fitted])
        assert len(pulls) >= CAMPAIGNS - 1
        assert (np.abs(pulls) < 4).all(), name
        assert abs(pulls.mean()) < 4 / np.sqrt(len(pulls)), name
    quality = np.mean([one.lines.chi2 / one.lines.freedom for one in campaigns])
    assert quality == pytest.approx(1, abs=4 * np.sqrt(2 / (2 * CAMPAIGNS * SHOTS)))


def test_the_fit_to_all_poses_agrees_and_is_surer(campaigns: list[Results]) -> None:
    for one in campaigns:
        for name, quantity in one.lines.parameters().items():
            whole = one.whole_fit[name]
            assert abs(whole.value - quantity.value) < 4 * quantity.sigma
            assert whole.sigma < 1.05 * quantity.sigma


def test_of_scalars_regression_and_fit_are_the_same_estimate(tmp_path: Path) -> None:
    """Both then maximise one likelihood, by ways that share no code."""
    _, table = gather(scalar_folder(tmp_path, 30, 5))
    assert isinstance(table, ContactTable)
    fitted = fit_campaign(table).parameters()
    for name, quantity in results(table).lines.parameters().items():
        whole = fitted[name]
        assert quantity.value == pytest.approx(whole.value, abs=0.05 * whole.sigma)
        assert quantity.sigma == pytest.approx(whole.sigma, rel=0.05)


def test_a_law_that_the_operator_lacks_shows_as_scatter(tmp_path: Path) -> None:
    write_challenge(tmp_path / "nylon", {"restitution-plastic": 0.02}, 3, SHOTS)
    found = results(gather(tmp_path / "nylon")[1])
    assert found.lines.scatter > 2
    assert found.speed is not None
    assert found.speed.slope < -5 * np.sqrt(found.speed.covariance[0, 0])


def test_every_shot_stands_in_the_tables_or_among_those_left_out(
    campaigns: list[Results],
) -> None:
    for found in campaigns:
        written = tables(found)
        listed = {row[0] for name in ("coefficients", "left-out") for row in written[name][1:]}
        assert listed == set(range(1, SHOTS + 1))
        for rows in written.values():
            assert len({len(row) for row in rows}) == 1
            assert not any(isinstance(cell, float) and np.isnan(cell) for r in rows for cell in r)


def test_the_lines_of_the_table_are_walton_s(campaigns: list[Results]) -> None:
    head, *rows = tables(campaigns[0])["figure-7-4-curves"]
    assert head == ["v_s_over_v_n", "walton", "maw_barber_fawcett"]
    e, mu, beta0 = NYLON.values()
    for x, y, _ in rows:
        assert y == pytest.approx(max(-beta0 * x, x - 3.5 * mu * (1 + e)), abs=0.02)


def test_maw_slides_with_walton_beyond_his_corner() -> None:
    x = np.linspace(0.8, 3, 20)
    walton = walton_curve(WaltonLaw(0.74, 0.08, 0.5), 3.5, x)
    np.testing.assert_allclose(maw_curve(0.74, 0.08, 3.5, x), walton, atol=2e-3)
    assert np.isnan(maw_curve(0.74, 0.0, 3.5, x)).all()


@pytest.mark.parametrize("shots", [1, 2, 6])
def test_figures_and_tables_are_there_for_few_shots(tmp_path: Path, shots: int) -> None:
    found = results(gather(scalar_folder(tmp_path, shots, 3))[1])
    assert found.lines.law.e == pytest.approx(0.74, abs=0.06)
    for draw in (plane_figure, restitution_figure, residual_figure):
        figure = draw(found)
        figure.canvas.draw()
        for axes in figure.axes:
            names = axes.get_legend_handles_labels()[1]
            drawn = {
                str(line.get_label()): np.isfinite(np.asarray(line.get_ydata(), float)).any()
                for line in axes.lines
            }
            assert all(drawn.get(name, True) for name in names)
    pulls = found.lines.held.normal_residual / found.lines.held.normal_sigma
    low, high = residual_figure(found).axes[0].get_ylim()
    assert low < pulls.min() <= pulls.max() < high
    assert len(tables(found)["coefficients"]) == 1 + len(found.impacts.shots)


def test_a_shot_that_the_fit_to_all_poses_drops_is_measured_all_the_same(tmp_path: Path) -> None:
    """That fit judges by its law; a compliant contact near the corner is no bad measurement."""
    write_challenge(tmp_path / "nylon", {"tangential-compliance": 1.0}, 7, 60)
    found = results(gather(tmp_path / "nylon")[1])
    assert any("shots left out" in remark for remark in found.remarks)
    assert list(found.impacts.shots) == list(range(1, 61))
    assert found.far == ()
    assert found.lines.scatter > 1.5
