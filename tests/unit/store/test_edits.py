"""What people change afterwards: kept with who, when and what stood there before."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable

import pytest

from rigctl.errors import NotFoundError, SettingsError, StoreError
from rigctl.store import ShotRecord, ShotState, Store
from tests.unit.store.conftest import perform, sqlite_alone, without_guard

Accepted = Callable[..., ShotRecord]


def changes(store: Store) -> list[tuple[str, str | None, str | None]]:
    return [(edit.act, edit.before, edit.after) for edit in store.edits.entries()]


def test_an_excluded_shot_says_why_and_counts_again_when_it_is_included(
    store: Store, accepted: Accepted
) -> None:
    shot = accepted().id
    assert store.exclude(shot, "the tube was dirty", "anna").excluded == "the tube was dirty"
    assert store.shot(shot).excluded == "the tube was dirty"
    assert store.include(shot, "ben").excluded is None
    assert changes(store) == [
        ("excluded", None, "the tube was dirty"),
        ("included", "the tube was dirty", None),
    ]
    who = [(edit.actor, edit.subject) for edit in store.edits.entries()]
    assert who == [("anna", shot), ("ben", shot)]


@pytest.mark.parametrize("reason", ["", "  \t"])
def test_an_exclusion_without_a_reason_is_refused_and_changes_nothing(
    store: Store, accepted: Accepted, reason: str
) -> None:
    shot = accepted().id
    with pytest.raises(SettingsError, match="reason: is empty"):
        store.exclude(shot, reason, "anna")
    assert store.shot(shot).excluded is None
    assert changes(store) == []


def test_a_note_and_tags_take_the_place_of_those_before_and_the_audit_keeps_these(
    store: Store, accepted: Accepted
) -> None:
    shot = accepted(note="as fired").id
    assert store.annotate(shot, "seen again", "anna").note == "seen again"
    assert store.tag(shot, ["wet", "first", "wet"], "anna").tags == ("first", "wet")
    assert store.tag(shot, [], "anna").tags == ()
    assert store.annotate(shot, None, "anna").note is None
    assert changes(store) == [
        ("noted", "as fired", "seen again"),
        ("tagged", None, "first,wet"),
        ("tagged", "first,wet", None),
        ("noted", "seen again", None),
    ]


def test_what_changes_nothing_is_not_written_down(store: Store, accepted: Accepted) -> None:
    shot = accepted(note="as fired").id
    store.annotate(shot, "as fired", "anna")
    store.include(shot, "anna")
    store.tag(shot, [], "anna")
    assert changes(store) == []


def test_a_shot_that_is_not_there_cannot_be_changed(store: Store) -> None:
    for change in (
        lambda: store.exclude("20260131-000001", "why", "anna"),
        lambda: store.include("20260131-000001", "anna"),
        lambda: store.annotate("20260131-000001", "note", "anna"),
        lambda: store.tag("20260131-000001", ["tag"], "anna"),
    ):
        with pytest.raises(NotFoundError, match="no such shot"):
            change()


def test_shots_are_found_by_tag_and_by_whether_they_count(store: Store, accepted: Accepted) -> None:
    names = [accepted(str(n)).id for n in range(4)]
    store.tag(names[1], ["wet", "cold"], "anna")
    store.tag(names[3], ["wet"], "anna")
    store.exclude(names[3], "why", "anna")
    assert [shot.id for shot in store.shots(tag="wet")] == [names[1], names[3]]
    assert [shot.tags for shot in store.shots(tag="wet")] == [("cold", "wet"), ("wet",)]
    assert [shot.id for shot in store.shots(excluded=True)] == [names[3]]
    assert [shot.id for shot in store.shots(tag="wet", excluded=False)] == [names[1]]
    assert store.campaigns.one("nylon").excluded == 1


def test_a_campaign_is_noted_and_tagged_and_the_audit_keeps_what_was_there(
    store: Store, accepted: Accepted
) -> None:
    accepted("1")
    accepted("2", campaign="brass")
    assert store.annotate_campaign("nylon", "a wet day", "anna").note == "a wet day"
    assert store.annotate_campaign("nylon", "a wet morning", "ben").note == "a wet morning"
    assert store.tag_campaign("nylon", ["wet", "first", "wet"], "anna").tags == ("first", "wet")
    assert store.tag_campaign("nylon", ["wet"], "anna").tags == ("wet",)
    assert store.annotate_campaign("nylon", None, "anna").note is None
    assert changes(store) == [
        ("campaign noted", None, "a wet day"),
        ("campaign noted", "a wet day", "a wet morning"),
        ("campaign tagged", None, "first,wet"),
        ("campaign tagged", "first,wet", "wet"),
        ("campaign noted", "a wet morning", None),
    ]
    assert {(edit.subject, edit.actor) for edit in store.edits.entries()} == {
        ("nylon", "anna"),
        ("nylon", "ben"),
    }
    assert store.edits.verify() == 5
    brass = store.campaigns.one("brass")
    assert (brass.note, brass.tags) == (None, ())


def test_campaigns_are_found_by_tag_and_their_shots_keep_their_own_words(
    store: Store, accepted: Accepted
) -> None:
    shot = accepted("1", note="of the shot").id
    accepted("2", campaign="brass")
    store.tag_campaign("brass", ["wet"], "anna")
    store.annotate_campaign("brass", "of the campaign", "anna")
    assert [one.name for one in store.campaigns.all("wet")] == ["brass"]
    assert store.campaigns.all("dry") == []
    assert {one.name: one.note for one in store.campaigns.all()} == {
        "brass": "of the campaign",
        "nylon": None,
    }
    assert (store.shot(shot).note, store.shot(shot).tags) == ("of the shot", ())


def test_what_changes_nothing_of_a_campaign_is_not_written_down(
    store: Store, accepted: Accepted
) -> None:
    accepted()
    store.annotate_campaign("nylon", None, "anna")
    store.tag_campaign("nylon", [], "anna")
    assert changes(store) == []


def test_a_campaign_that_is_not_there_cannot_be_noted(store: Store) -> None:
    for change in (
        lambda: store.annotate_campaign("steel", "note", "anna"),
        lambda: store.tag_campaign("steel", ["tag"], "anna"),
    ):
        with pytest.raises(NotFoundError, match="no such campaign"):
            change()
    assert changes(store) == []


def test_listeners_hear_of_every_change(store: Store, accepted: Accepted) -> None:
    heard: list[ShotRecord] = []
    shot = accepted().id
    store.listeners.add(heard.append)
    store.exclude(shot, "why", "anna")
    store.tag(shot, ["wet"], "anna")
    assert [(record.excluded, record.tags) for record in heard] == [("why", ()), ("why", ("wet",))]


def test_an_excluded_shot_is_no_longer_among_the_measured_ones(
    store: Store, accepted: Accepted
) -> None:
    names = [accepted(str(n)).id for n in range(2)]
    for shot in names:
        for state in ("firing", "capturing", "stored", "analysing", "analysed"):
            store.move(shot, ShotState(state))
    store.exclude(names[0], "why", "anna")
    assert [shot for shot, _ in store.campaigns.measured("nylon")] == [names[1]]
    assert [shot for shot, _ in store.campaigns.left_out("nylon")] == [names[0]]


def test_the_audit_of_changes_cannot_be_altered_unseen(store: Store, accepted: Accepted) -> None:
    shot = accepted().id
    store.exclude(shot, "why", "anna")
    store.include(shot, "anna")
    assert store.edits.verify() == 2
    alter = "UPDATE edits SET actor = 'ben' WHERE number = 2"
    with pytest.raises(StoreError, match="append-only"):
        perform(store, alter)
    without_guard(store, "edits")
    perform(store, alter)
    with pytest.raises(StoreError, match=r"altered.*edit 2"):
        store.edits.verify()


def test_a_store_that_another_process_owns_can_be_edited_beside_it(
    store: Store, accepted: Accepted
) -> None:
    shot = accepted().id
    beside = Store(store.path, database=store.address, shared=True)
    beside.exclude(shot, "why", "anna")
    beside.close()
    assert store.shot(shot).excluded == "why"


def test_whoever_edits_does_not_keep_the_daemon_out(store: Store) -> None:
    store.close()
    beside = Store(store.path, database=store.address, shared=True)
    Store(store.path, database=store.address).close()
    beside.close()


@sqlite_alone
def test_a_catalogue_of_an_earlier_form_is_not_changed_under_its_owner(store: Store) -> None:
    file = sqlite3.connect(store.path / "catalogue.db")
    file.execute("PRAGMA user_version = 1")
    file.close()
    with pytest.raises(StoreError, match=r"earlier version.*schema 1.*rigctl serve"):
        Store(store.path, database=store.address, shared=True)
