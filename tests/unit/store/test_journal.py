"""The audit: appended, chained, and every alteration found."""

from __future__ import annotations

import hashlib
import json
from datetime import UTC, datetime

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rigctl.errors import StoreError
from rigctl.store import Store
from tests.unit.store.conftest import perform, without_guard

AT = datetime(2026, 1, 31, 12, 0, tzinfo=UTC)


def written(store: Store, entries: int = 4) -> None:
    for n in range(entries):
        store.journal.append(at=AT, before="idle", after="estop", actor="anna", reason=f"no. {n}")


def test_entries_come_back_in_order_with_what_was_given(store: Store) -> None:
    written(store)
    assert [entry.reason for entry in store.journal.entries(after=1, limit=2)] == ["no. 1", "no. 2"]
    last = store.journal.last()
    assert (last.number, last.at, last.before, last.after) == (4, AT, "idle", "estop")


def test_an_untouched_chain_verifies(store: Store) -> None:
    assert store.journal.verify() == 0
    written(store)
    assert store.journal.verify() == 4


def test_the_digest_is_that_of_the_entry_before_and_of_all_fields(store: Store) -> None:
    written(store, 1)
    fields = ["0" * 64, 1, AT.isoformat(), "idle", "estop", "anna", "no. 0", None]
    text = json.dumps(fields, separators=(",", ":"))
    assert store.journal.last().digest == hashlib.sha256(text.encode()).hexdigest()


@pytest.mark.parametrize("act", ["UPDATE transitions SET actor = 'x'", "DELETE FROM transitions"])
def test_the_database_itself_refuses_to_change_an_entry(store: Store, act: str) -> None:
    written(store)
    with pytest.raises(StoreError, match="append-only"):
        perform(store, act)
    assert store.journal.verify() == 4


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE transitions SET actor = 'berta' WHERE number = 2",
        "UPDATE transitions SET reason = 'other' WHERE number = 4",
        "UPDATE transitions SET shot = NULL, at = '2026-01-31T12:00:01+00:00' WHERE number = 1",
        "DELETE FROM transitions WHERE number = 2",
        "DELETE FROM transitions WHERE number = 1",
    ],
)
def test_an_alteration_behind_the_programs_back_breaks_the_chain(
    store: Store, statement: str
) -> None:
    written(store)
    without_guard(store, "transitions")
    perform(store, statement)
    with pytest.raises(StoreError, match="altered"):
        store.journal.verify()


def test_the_chain_goes_on_after_a_restart(store: Store) -> None:
    written(store)
    store.close()
    again = Store(store.path, database=store.address)
    written(again)
    assert again.journal.verify() == 8
    again.close()


@given(actor=st.text(), reason=st.text())
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_text_comes_back_as_it_was_and_keeps_the_chain(
    store: Store, actor: str, reason: str
) -> None:
    try:
        reason.encode()
        actor.encode()
    except UnicodeEncodeError:
        return
    store.journal.append(at=AT, before="a", after="b", actor=actor, reason=reason)
    last = store.journal.last()
    assert (last.actor, last.reason) == (actor, reason)
    assert store.journal.verify() == last.number
