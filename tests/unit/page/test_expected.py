"""What the form of the next shot expects, against shots whose numbers follow from mechanics."""

from __future__ import annotations

import pytest

from rigctl.page.parts.readings import Impact
from rigctl.page.rig.order_form import expected, sentence
from rigctl.settings import ShotSettings

HEAD_ON = Impact(3, (-3.0, 0.01), (0.0, 0.01), (0.74, 0.01), None)


def settings(pressure: float, offset: float) -> ShotSettings:
    return ShotSettings(
        pressure_a_kpa=pressure, pressure_b_kpa=pressure, offset_mm=offset, delay_us=0
    )


def test_four_times_the_pressure_meets_twice_as_fast() -> None:
    found = expected(HEAD_ON, settings(20, 0), settings(80, 0), 25.4)
    assert found == pytest.approx((6.0, 0.0))


def test_an_offset_of_half_a_diameter_meets_thirty_degrees_off_head_on() -> None:
    found = expected(HEAD_ON, settings(20, 0), settings(20, 12.7), 25.4)
    assert found is not None
    assert found == pytest.approx((3.0 * 3**0.5 / 2, 30.0))
    assert "2.6 m/s, 30° off head on" in sentence(3, *found)


def test_spheres_that_miss_are_not_expected_to_meet() -> None:
    assert expected(HEAD_ON, settings(20, 0), settings(20, 26), 25.4) is None
