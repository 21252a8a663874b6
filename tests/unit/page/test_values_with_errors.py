"""A value in a table is written with its error, or as not determined."""

from rigctl.page.parts.quantities import COEFFICIENTS
from rigctl.page.parts.tables import measured, with_error


def test_a_value_that_was_not_measured_is_not_determined() -> None:
    assert with_error({"value": None, "sigma": None}) == "not determined"
    assert with_error({"value": None, "sigma": None}, 1000.0) == "not determined"


def test_a_value_has_the_places_that_its_error_allows() -> None:
    text = with_error({"value": 0.73912345, "sigma": 0.0012})
    number, error = (float(part) for part in text.split("±"))
    assert abs(number - 0.73912345) < 0.0012 / 2
    assert abs(error - 0.0012) < 0.0012 / 2
    assert len(text) < len("0.73912345 ± 0.0012")


def test_the_speed_of_approach_is_shown_as_a_speed_though_files_hold_it_signed() -> None:
    line = measured(COEFFICIENTS["v_n"], {"value": -3.3587, "sigma": 0.0032})
    assert line.cells[1] == "3.3587 ± 0.0032"
