"""Solenoids and a magnet: which switching lets which sphere go, and when."""

from __future__ import annotations

import pytest

from simulators.holders import COMMAND_S, TOGETHER_S, Holders
from simulators.world.release import Release


class Held:
    """Holders with a clock that stands until it is moved, and what they let go."""

    def __init__(self, *channels: int, holds_energised: bool = True) -> None:
        self.now, self.gone = 10.0, []
        self.holders = Holders(
            channels,
            holds_energised=holds_energised,
            clock=lambda: self.now,
            release=self.gone.append,
        )

    def load(self) -> None:
        self.holders.power(True)
        for channel in (1, 2):
            self.now += 1.0
            self.holders.switch(channel, True)
        self.now += 1.0


@pytest.fixture
def pair() -> Held:
    held = Held(1, 2)
    held.load()
    return held


def test_spheres_that_are_held_stay(pair: Held) -> None:
    assert pair.gone == []


def test_of_two_commands_that_arrive_together_the_second_acts_a_commands_time_later(
    pair: Held,
) -> None:
    pair.holders.switch(1, False)
    pair.holders.switch(2, False)
    assert pair.gone == [Release(pair.now, pair.now + COMMAND_S)]


def test_a_power_cut_drops_both_spheres_at_once(pair: Held) -> None:
    pair.holders.power(False)
    assert pair.gone == [Release(pair.now, pair.now)]


def test_a_sphere_falls_once_whatever_is_switched_then(pair: Held) -> None:
    pair.holders.power(False)
    pair.holders.switch(1, False)
    pair.holders.power(True)
    pair.holders.power(False)
    assert len(pair.gone) == 1


def test_solenoids_with_springs_hold_without_power_and_let_go_with_it() -> None:
    pair = Held(1, 2, holds_energised=False)
    pair.holders.power(True)
    assert pair.gone == []
    pair.holders.power(False)
    pair.holders.switch(1, True)
    pair.holders.switch(2, True)
    assert pair.gone == []
    pair.holders.power(True)
    assert pair.gone == [Release(pair.now, pair.now)]


def test_a_magnet_drops_its_sphere_alone() -> None:
    magnet = Held(1)
    magnet.load()
    magnet.holders.switch(1, False)
    assert magnet.gone == [Release(magnet.now, None)]


def test_a_sphere_whose_fellow_stays_goes_alone_after_the_longest_delay(pair: Held) -> None:
    pair.holders.switch(2, False)
    pair.holders.close()
    # The timer is the host's own; what it does is asked of it at once.
    assert TOGETHER_S > 0.1
    pair.holders.switch(2, True)
    pair.holders.switch(2, False)
    assert pair.gone == [Release(None, 13.0)]


def test_a_world_without_holders_hears_nothing() -> None:
    pushers = Held()
    pushers.load()
    pushers.holders.switch(1, False)
    pushers.holders.power(False)
    assert pushers.gone == []
