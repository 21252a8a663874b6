import pytest

from analysis.errors import counted


@pytest.mark.parametrize(
    ("number", "text"), [(0, "0 markers"), (1, "1 marker"), (2, "2 markers"), (11, "11 markers")]
)
def test_one_is_counted_in_the_singular(number: int, text: str) -> None:
    assert counted(number, "marker") == text
