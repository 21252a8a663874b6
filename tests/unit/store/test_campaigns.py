"""Campaigns as the catalogue counts them."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime

import pytest

from rigctl.errors import NotFoundError
from rigctl.store import Change, ShotRecord, ShotState, Store

Accepted = Callable[..., ShotRecord]
MEASURED = ("firing", "capturing", "stored", "analysing", "analysed")


def at(hour: int) -> datetime:
    return datetime(2026, 1, 31, hour, tzinfo=UTC)


def carry(store: Store, shot: str, *states: str, results: int | None = None) -> None:
    for state in states[:-1]:
        store.move(shot, ShotState(state))
    store.move(shot, ShotState(states[-1]), Change(results=results))


def test_a_campaign_counts_its_shots_by_state_and_knows_its_first_and_last(
    store: Store, accepted: Accepted
) -> None:
    for hour in (9, 8, 11):
        accepted(str(hour), accepted_at=at(hour))
    accepted("other", campaign="brass")
    carry(store, "20260131-000002", "aborted")
    campaign = store.campaigns.one("nylon")
    assert campaign.states == {ShotState.ABORTED: 1, ShotState.ACCEPTED: 2}
    assert (campaign.shots, campaign.first_at, campaign.last_at) == (3, at(8), at(11))


def test_the_campaign_with_the_latest_shot_comes_first_and_shots_without_one_are_in_none(
    store: Store, accepted: Accepted
) -> None:
    accepted("1", campaign="a", accepted_at=at(10))
    accepted("2", campaign="b", accepted_at=at(12))
    accepted("3", campaign="c", accepted_at=at(11))
    accepted("4", campaign=None)
    assert [campaign.name for campaign in store.campaigns.all()] == ["b", "c", "a"]


def test_only_shots_with_a_measurement_are_measured_each_with_its_latest_result(
    store: Store, accepted: Accepted
) -> None:
    names = [accepted(str(number)).id for number in range(4)]
    carry(store, names[0], *MEASURED, results=3)
    carry(store, names[1], "firing", "capturing", "stored", "analysing", "refused", results=1)
    carry(store, names[3], *MEASURED, results=1)
    assert store.campaigns.measured("nylon") == [(names[0], 3), (names[3], 1)]


def test_a_name_without_shots_is_no_campaign(store: Store) -> None:
    assert store.campaigns.all() == []
    for ask in (store.campaigns.one, store.campaigns.measured):
        with pytest.raises(NotFoundError, match="no such campaign \\(found 'nylon'\\)"):
            ask("nylon")


def test_a_campaign_without_a_measured_shot_says_so(store: Store, accepted: Accepted) -> None:
    accepted()
    with pytest.raises(NotFoundError, match="no shot of this campaign has been measured"):
        store.campaigns.measured("nylon")
