"""Foretold leads against least squares on drawn data: linear theories, no shot numbers."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.model.design.duel import Leads

Floats = NDArray[np.float64]

CAMPAIGN, SETTINGS, EACH = 30, 3, 9
FUTURES = 3000


@dataclass(frozen=True)
class World:
    """Columns of a truth and its rival in a campaign and at settings, and measured noise."""

    truth: list[Floats]
    rival: list[Floats]
    amplitudes: Floats
    noise: Floats


def drawn(own: int, other: int, seed: int) -> World:
    rng = np.random.default_rng(seed)
    rows = [CAMPAIGN, *[EACH] * SETTINGS]
    common = [rng.standard_normal((n, 1)) for n in rows]
    truth = [np.hstack([c, rng.standard_normal((len(c), own))]) for c in common]
    rival = [
        np.hstack([c, t[:, 1:2] + 0.3 * rng.standard_normal((len(c), 1)),
                   rng.standard_normal((len(c), other - 1))])
        for c, t in zip(common, truth, strict=True)
    ]  # fmt: skip
    return World(truth, rival, np.array([3.0, *[0.9] * own]), rng.standard_normal(CAMPAIGN))


def left(columns: Floats, numbers: Floats) -> float:
    """Return chi-squared after least squares."""
    solved = np.linalg.lstsq(columns, numbers, rcond=None)[0]
    return float(((numbers - columns @ solved) ** 2).sum())


def foretold(world: World) -> tuple[Leads, Floats]:
    """Return leads about both fits of the campaign, and the truth's fit."""
    measured = world.truth[0] @ world.amplitudes + world.noise
    best, beside = (
        np.linalg.lstsq(part[0], measured, rcond=None)[0] for part in (world.truth, world.rival)
    )
    columns = [
        np.hstack([t, r, (t @ best - r @ beside)[:, None]])
        for t, r in zip(world.truth, world.rival, strict=True)
    ]
    grams = [part.T @ part for part in columns]
    more = len(best) - len(beside)
    ahead = left(world.rival[0], measured) - left(world.truth[0], measured)
    leads = Leads(
        campaign=grams[0],
        settings=np.array(grams[1:]),
        observed=columns[0].T @ (measured - world.truth[0] @ best),
        priors=tuple((np.zeros(len(v)), np.zeros(len(v))) for v in (best, beside)),  # type: ignore[arg-type]
        shots=12,
        ahead=ahead - more * float(np.log(12)),
    )
    return leads, best


@pytest.mark.parametrize(("own", "other"), [(1, 1), (1, 2), (2, 1)])
def test_the_leads_are_those_of_futures_that_are_drawn_and_fitted(own: int, other: int) -> None:
    world = drawn(own, other, seed=own + 2 * other)
    leads, best = foretold(world)
    counts = np.array([2.0, 0.0, 1.0])
    truth, rival = (
        np.concatenate([part[0], part[1], part[1], part[3]]) for part in (world.truth, world.rival)
    )
    rng = np.random.default_rng(8)
    spread = np.linalg.cholesky(np.linalg.inv(world.truth[0].T @ world.truth[0]))
    measured = world.truth[0] @ world.amplitudes + world.noise
    found = []
    for _ in range(FUTURES):
        true = best + spread @ rng.standard_normal(len(best))
        later = truth[CAMPAIGN:] @ true + rng.standard_normal(len(truth) - CAMPAIGN)
        numbers = np.concatenate([measured, later])
        found.append(left(rival, numbers) - left(truth, numbers))
    expected = np.array(found) - (own - other) * np.log(15)
    after = leads.after(counts)
    error = np.std(expected) / np.sqrt(FUTURES)
    assert after.mean() == pytest.approx(expected.mean(), abs=5 * error)
    assert after.std() == pytest.approx(np.std(expected), rel=0.1)
    assert (after > 0).mean() == pytest.approx((expected > 0).mean(), abs=0.04)


def test_without_more_shots_the_lead_is_what_it_is() -> None:
    leads, _ = foretold(drawn(1, 2, seed=3))
    assert leads.after(np.zeros(SETTINGS)) == pytest.approx(leads.ahead, abs=1e-6)
