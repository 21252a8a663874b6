"""What the demonstration prints of the way to its verdict."""

from __future__ import annotations

from rigctl.cli.rig.demo import taken_out


def test_an_effect_that_was_added_and_dropped_again_is_named() -> None:
    way = [[], ["finite-contact"], ["finite-contact", "drag", "magnus-lift"], ["drag"]]
    assert taken_out(way) == ["finite-contact", "magnus-lift"]


def test_of_a_way_that_only_adds_nothing_is_said() -> None:
    assert taken_out([[], ["drag"], ["drag", "wind"]]) == []
    assert taken_out([[]]) == []
