"""No way into the store takes a character that is not shown as it is stored."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rigctl.errors import SettingsError
from rigctl.plain_text import require_plain
from rigctl.store import ShotRecord, Store

REVERSED = "all is \u202elluf"


@pytest.mark.parametrize(
    "change",
    [
        lambda store, shot: store.annotate(shot, REVERSED, "anna"),
        lambda store, shot: store.exclude(shot, REVERSED, "anna"),
        lambda store, shot: store.annotate(shot, "a slow start", REVERSED),
        lambda store, shot: store.annotate_campaign("nylon", REVERSED, "anna"),
    ],
)
def test_a_change_with_such_a_character_is_refused_and_leaves_nothing(
    store: Store, accepted: Callable[..., ShotRecord], change: Callable[[Store, str], object]
) -> None:
    shot = accepted(campaign="nylon").id
    with pytest.raises(SettingsError, match=r"U\+202E at character 8"):
        change(store, shot)
    assert store.edits.entries() == []
    assert store.shot(shot).note is None
    assert store.shot(shot).excluded is None


@pytest.mark.parametrize("part", ["note", "actor"])
def test_no_shot_is_accepted_with_such_a_character(
    store: Store, accepted: Callable[..., ShotRecord], part: str
) -> None:
    with pytest.raises(SettingsError, match=part):
        accepted(**{part: REVERSED})
    assert store.shots() == []


def test_what_joins_letters_is_taken() -> None:
    require_plain("می‌خواهم, 👩‍🔬", "note")
