"""Plans of sweeps: what is foreseen of their steps before anything moves."""

from __future__ import annotations

from dataclasses import replace

from bench import plan

from rigctl.config import Configuration, load
from rigctl.sweeps.plan import warnings_of


def with_spheres(diameter_m: float) -> Configuration:
    usual = load()
    spheres = tuple(replace(s, diameter_m=diameter_m) for s in usual.spheres)
    return usual.model_copy(update={"spheres": spheres})


def test_steps_whose_spheres_cannot_meet_are_counted_and_the_first_is_described() -> None:
    [warning] = warnings_of(plan((2.0, 13.0, 15.0)), with_spheres(0.0127))
    assert warning.startswith("2 of 3 shots will miss")
    assert "offset_mm is 13 mm, the sum of their radii 12.7 mm" in warning


def test_steps_whose_spheres_meet_need_no_warning() -> None:
    assert warnings_of(plan((2.0, 13.0, 15.0)), with_spheres(0.0254)) == ()
