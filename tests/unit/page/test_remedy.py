"""A refused shot in the user's words: the setting that kept the spheres from meeting."""

from __future__ import annotations

import pytest

from rigctl.page.shots.overlay import Overlays
from rigctl.page.shots.refused import AGAIN, end_apart, remedy
from rigctl.settings import ShotSettings
from tests.unit.page.test_guide_progress import limits

DIAMETER_M = 0.0254


def fired(
    a: float = 40.0, b: float = 40.0, offset: float = 6.0, delay: float = 0.0
) -> ShotSettings:
    return ShotSettings(pressure_a_kpa=a, pressure_b_kpa=b, offset_mm=offset, delay_us=delay)


@pytest.mark.parametrize(
    ("settings", "word", "changed"),
    [
        (fired(delay=-20_000), "b started 20 ms before a", {"delay_us": 0.0}),
        (fired(delay=8_000), "a started 8 ms before b", {"delay_us": 0.0}),
        (fired(offset=24), "flew past each other", {"offset_mm": 6.0}),
        (fired(a=100), "much harder", {"pressure_b_kpa": 100.0}),
        (fired(a=5, b=5), "fell out", {"pressure_a_kpa": 40.0, "pressure_b_kpa": 40.0}),
    ],
)
def test_the_setting_that_is_to_blame_is_named_and_mended(
    settings: ShotSettings, word: str, changed: dict[str, float]
) -> None:
    said = remedy("contact", settings, limits(), DIAMETER_M)
    assert word in said.happened
    assert said.settings == settings.model_copy(update=changed)
    assert said.settings != settings


def test_a_good_setting_is_fired_again() -> None:
    said = remedy("contact", fired(), limits(), DIAMETER_M)
    assert (said.settings, said.button) == (fired(), AGAIN)


def test_pictures_without_dots_are_no_fault_of_the_settings() -> None:
    said = remedy("markers", fired(delay=-20_000), limits(), DIAMETER_M)
    assert "dots" in said.happened
    assert said.settings.delay_us == -20_000


def test_what_is_set_instead_lies_within_the_limits_of_the_rig() -> None:
    narrow = limits(offset_mm=(8.0, 24.0), pressure_kpa=(5.0, 30.0))
    assert remedy("contact", fired(offset=24), narrow, DIAMETER_M).settings.offset_mm == 8.0
    assert remedy("contact", fired(5, 5), narrow, DIAMETER_M).settings.pressure_a_kpa == 30.0


def frame(between_px: float) -> dict[str, object]:
    """Return what is found of two spheres of radius 20 px whose centres are so far apart."""
    front = [
        {"sphere": name, "view": "front", "row": 80.0, "column": column, "radius": 20.0}
        for name, column in (("a", 60.0), ("b", 60.0 + between_px))
    ]
    above = [{**one, "view": "top", "column": 0.0} for one in front]
    return {"outlines": [*front, *above]}


def test_a_film_that_ends_before_the_spheres_meet_is_called_too_short() -> None:
    nearer, touching = [90.0, 80.0, 70.0], [60.0, 40.0, 39.9]
    apart = [end_apart(Overlays([frame(d) for d in row], None, None)) for row in (nearer, touching)]
    assert apart == [True, False]
    assert not end_apart(Overlays([frame(d) for d in (70.0, 50.0, 65.0)], None, None))
    assert not end_apart(Overlays([{"outlines": []}], None, None))
    said = remedy("contact", fired(a=20, b=20), limits(), DIAMETER_M, ends_apart=True)
    assert said.happened.startswith("The film ends before the spheres meet")
