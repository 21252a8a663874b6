"""Units of parameters: what is known has its dimension, what is not is refused."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.effects.catalogue import CATALOGUE
from analysis.effects.own.units import Dimension

KNOWN = [
    ("1", (0, 0, 0, 0)),
    ("rad", (0, 0, 0, 0)),
    ("m/s^2", (1, -2, 0, 0)),
    ("kg m/s", (1, -1, 1, 0)),
    ("m^2/s^2", (2, -2, 0, 0)),
    ("(m/s)^-0.2", (-0.2, 0.2, 0, 0)),
    ("1/(kg m)", (-1, 0, -1, 0)),
    ("1/K", (0, 0, 0, -1)),
    ("kg/m^3", (-3, 0, 1, 0)),
    ("N", (1, -2, 1, 0)),
    ("J", (2, -2, 1, 0)),
    ("1/kPa", (1, 2, -1, 0)),
    ("rad/s", (0, -1, 0, 0)),
]
UNKNOWN = [
    "",
    " ",
    "furlong",
    "m/s/s",
    "m**2",
    "m^",
    "deg",
    "m s-1",
    "(m",
    "m//s",
    "M",
    "m  s",
    "m^x",
]


@pytest.mark.parametrize(("unit", "exponents"), KNOWN)
def test_a_known_unit_has_its_dimension(unit: str, exponents: tuple[float, ...]) -> None:
    assert Dimension.of(unit).exponents == pytest.approx(exponents)


@pytest.mark.parametrize("unit", UNKNOWN)
def test_what_is_no_unit_is_refused(unit: str) -> None:
    with pytest.raises(ValueError, match=r"no unit|divided"):
        Dimension.of(unit)


def test_every_unit_of_the_catalogue_is_known() -> None:
    for effect in CATALOGUE:
        for parameter in effect.parameters:
            Dimension.of(parameter.unit)


POWERS = st.integers(-4, 4).filter(bool)


@given(st.dictionaries(st.sampled_from(["m", "s", "kg", "K"]), POWERS, min_size=1))
def test_a_dimension_reads_as_the_unit_it_came_from(powers: dict[str, int]) -> None:
    unit = " ".join(f"{symbol}^{power}" for symbol, power in powers.items())
    found = Dimension.of(unit)
    assert found.exponents == tuple(powers.get(symbol, 0) for symbol in ("m", "s", "kg", "K"))
    assert Dimension.of(str(found)) == found


@given(st.text(max_size=12))
def test_any_text_is_a_unit_or_is_refused(text: str) -> None:
    with contextlib.suppress(ValueError):
        assert len(Dimension.of(text).exponents) == 4
