"""A value in a table is written with its error, or as not determined."""

from rigctl.page.parts.tables import with_error


def test_a_value_that_was_not_measured_is_not_determined() -> None:
    assert with_error({"value": None, "sigma": None}) == "not determined"
    assert with_error({"value": None, "sigma": None}, 1000.0) == "not determined"


def test_a_value_has_the_places_that_its_error_allows() -> None:
    text = with_error({"value": 0.73912345, "sigma": 0.0012})
    number, error = (float(part) for part in text.split("±"))
    assert abs(number - 0.73912345) < 0.0012 / 2
    assert abs(error - 0.0012) < 0.0012 / 2
    assert len(text) < len("0.73912345 ± 0.0012")
