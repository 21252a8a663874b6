"""What an analysing process remembers from shot to shot."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analysis.campaign import THESIS_SETUP
from analysis.setup import Setup
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot
from rigctl import stored_shot

FRAMES, TIMES = np.zeros((6, 4, 4), np.uint8), np.linspace(0.0, 5e-3, 6)
PHOTOMETRIC = AnalysisOptions(method="photometric")


class Analysis:
    """Stands for `analyse_shot`: notes what was known, and teaches `lesson` unless it refuses."""

    def __init__(self) -> None:
        self.known: list[object] = []
        self.lesson: Any = "first"
        self.refuses = False

    def __call__(self, *arguments: Any) -> MeasuredShot | RefusedShot:
        self.known.append(arguments[4])
        if self.refuses:
            return RefusedShot("frames", "dark", None)
        nothing: Any = None
        empty = (nothing, nothing)
        return MeasuredShot(
            nothing, empty, empty, nothing, TIMES, (), (), (), arguments[4] or self.lesson
        )


@pytest.fixture
def analysis(monkeypatch: pytest.MonkeyPatch) -> Analysis:
    double = Analysis()
    monkeypatch.setattr(stored_shot, "analyse_shot", double)
    monkeypatch.setattr(stored_shot, "_LEARNED", {})
    return double


def measure(setup: Setup = THESIS_SETUP) -> None:
    stored_shot.measured(FRAMES, TIMES, setup, PHOTOMETRIC)


def test_the_spheres_of_a_set_up_are_learned_once(analysis: Analysis) -> None:
    for _ in range(3):
        measure()
    assert analysis.known == [None, "first", "first"]


def test_another_set_up_is_learned_on_its_own(analysis: Analysis) -> None:
    measure()
    measure(replace(THESIS_SETUP, gravity_m_per_s2=9.7))
    assert analysis.known == [None, None]


def test_a_refused_shot_teaches_nothing(analysis: Analysis) -> None:
    analysis.refuses = True
    measure()
    analysis.refuses = False
    measure()
    assert analysis.known == [None, None]


def test_only_the_latest_set_ups_are_kept(analysis: Analysis) -> None:
    setups = [replace(THESIS_SETUP, gravity_m_per_s2=9.0 + 0.1 * n) for n in range(5)]
    for setup in setups:
        measure(setup)
    measure(setups[0])
    measure(setups[4])
    assert analysis.known == [None] * 6 + ["first"]
