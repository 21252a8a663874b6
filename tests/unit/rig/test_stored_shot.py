"""What the analysing processes of a store remember from shot to shot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import rigctl.measuring.stored_shot
from analysis.campaign import THESIS_SETUP
from analysis.photometric.learn.appearance import Appearance, Sphere
from analysis.photometric.render.camera import camera_of
from analysis.setup import Environment, Setup
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot
from rigctl.measuring.learned_pairs import LearnedPairs
from rigctl.measuring.stored_shot import CampaignLearning

FRAMES, TIMES = np.zeros((6, 4, 4), np.uint8), np.linspace(0.0, 5e-3, 6)


def lesson(darkness: float) -> Appearance:
    camera = camera_of(THESIS_SETUP.camera, np.array([1574.8, 1574.8]))
    sphere = Sphere(0.0127, np.eye(3), 0.16, darkness, np.zeros((2, 16)), np.zeros((2, 5, 5)))
    numbers: dict[str, Any] = {"sigma_px": np.full(2, 0.85), "scale_sigma": 7e-4}
    numbers |= {
        "camera_sigma": (0.0, 0.0),
        "limb_px": 0.0,
        "films": 6,
        "pattern_sigma_rad": 2e-4,
        "slow_px": 0.0,
        "shared_px": 0.0,
        "smear_px2": np.zeros(2),
    }
    own = {name: numbers[name] for name in Appearance.__slots__ if name in numbers}
    return Appearance(camera=camera, spheres=(sphere, sphere), **own)


class Analysis:
    """Stands for `analyse_shot`: notes what was known, and teaches where it does not believe it."""

    def __init__(self) -> None:
        self.known: list[float | None] = []
        self.extended: list[bool] = []
        self.shown = 0.5
        self.refuses = False

    def __call__(self, *arguments: Any, extend: bool = False) -> MeasuredShot | RefusedShot:
        self.extended.append(extend)
        known = arguments[4]
        self.known.append(None if known is None else known.spheres[0].darkness)
        if self.refuses:
            return RefusedShot("frames", "dark", None)
        alone = known is None or known.spheres[0].darkness != self.shown
        if alone:
            known = lesson(self.shown)
        nothing: Any = None
        empty, tracking = (nothing, nothing), cast("Any", SimpleNamespace(learned_alone=alone))
        return MeasuredShot(nothing, empty, empty, tracking, TIMES, (), (), (), (), empty, known)


@pytest.fixture
def analysis(monkeypatch: pytest.MonkeyPatch) -> Analysis:
    double = Analysis()
    monkeypatch.setattr(rigctl.measuring.stored_shot, "analyse_shot", double)
    return double


@pytest.fixture
def process(tmp_path: Path) -> LearnedPairs:
    return LearnedPairs(tmp_path / "learned")


@pytest.fixture
def other_process(tmp_path: Path) -> LearnedPairs:
    return LearnedPairs(tmp_path / "learned")


def measure(
    pairs: LearnedPairs,
    setup: Setup = THESIS_SETUP,
    campaign: str | None = "nylon",
    shot: str = "20261123-000001",
) -> CampaignLearning:
    folder = Path("shots/20261123") / shot
    own = CampaignLearning(folder, campaign, pairs, lambda _: (FRAMES, TIMES, setup))
    own.measure(FRAMES, TIMES, setup, AnalysisOptions())
    return own


def test_the_spheres_of_a_campaign_are_learned_once(
    analysis: Analysis, process: LearnedPairs
) -> None:
    for _ in range(3):
        measure(process)
    assert analysis.known == [None, 0.5, 0.5]


def test_what_one_process_learns_serves_the_others(
    analysis: Analysis, process: LearnedPairs, other_process: LearnedPairs
) -> None:
    measure(process)
    measure(other_process)
    assert analysis.known == [None, 0.5]


def test_changed_spheres_teach_anew_and_their_lesson_goes_to_all_processes(
    analysis: Analysis, process: LearnedPairs, other_process: LearnedPairs
) -> None:
    measure(process)
    measure(other_process)
    analysis.shown = 0.7
    measure(process)
    measure(other_process)
    assert analysis.known == [None, 0.5, 0.5, 0.7]


@pytest.mark.parametrize(
    ("setup", "campaign"),
    [(replace(THESIS_SETUP, environment=Environment(9.7)), "nylon"), (THESIS_SETUP, "brass")],
)
def test_another_set_up_and_another_campaign_are_learned_on_their_own(
    analysis: Analysis, process: LearnedPairs, setup: Setup, campaign: str
) -> None:
    measure(process)
    measure(process, setup, campaign)
    assert analysis.known == [None, None]


def test_another_exposure_needs_no_other_lesson(analysis: Analysis, process: LearnedPairs) -> None:
    measure(process)
    measure(process, replace(THESIS_SETUP, camera=replace(THESIS_SETUP.camera, exposure_s=2e-4)))
    assert analysis.known == [None, 0.5]


def names(count: int) -> list[str]:
    return [f"20261123-{n:06d}" for n in range(1, count + 1)]


def test_six_shots_teach_together_and_the_first_five_are_measured_again(
    analysis: Analysis, process: LearnedPairs, monkeypatch: pytest.MonkeyPatch
) -> None:
    taught: list[int] = []

    def teach(shots: list[Any]) -> Appearance:
        taught.append(len(shots))
        analysis.shown = 0.9
        return lesson(0.9)

    monkeypatch.setattr("analysis.photometric.teaching.teach", teach)
    again = [measure(process, shot=name).again for name in names(8)]
    assert taught == [6]
    assert again == [()] * 5 + [tuple(names(5))] + [()] * 2
    assert analysis.known == [None, *[0.5] * 5, 0.9, 0.9, 0.9]
    # What is learned together is used as it is; later shots add the sides that they show first.
    assert analysis.extended == [True] * 6 + [False] + [True] * 2


def test_a_side_that_no_shot_has_shown_yet_is_no_reason_to_forget_the_others(
    analysis: Analysis, process: LearnedPairs
) -> None:
    first, second, third = names(3)
    measure(process, shot=first)
    analysis.shown = 0.7
    measure(process, shot=second)
    analysis.shown = 0.5
    measure(process, shot=third)
    assert analysis.known == [None, 0.5, 0.5]
    assert process.teachers("nylon", THESIS_SETUP) == (first, second, third)


def test_other_spheres_after_the_pair_is_known_begin_anew(
    analysis: Analysis, process: LearnedPairs, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("analysis.photometric.teaching.teach", lambda _: lesson(0.5))
    for name in names(6):
        measure(process, shot=name)
    analysis.shown = 0.7
    seventh, eighth = names(8)[6:]
    measure(process, shot=seventh)
    measure(process, shot=eighth)
    assert analysis.known[-2:] == [0.5, 0.7]
    assert process.teachers("nylon", THESIS_SETUP) == (seventh, eighth)


def test_a_shot_that_is_measured_again_teaches_no_second_time(
    analysis: Analysis, process: LearnedPairs
) -> None:
    for _ in range(9):
        measure(process)
    assert process.teachers("nylon", THESIS_SETUP) == (names(1)[0],)


def test_a_refused_shot_teaches_nothing(analysis: Analysis, process: LearnedPairs) -> None:
    analysis.refuses = True
    measure(process)
    analysis.refuses = False
    measure(process)
    assert analysis.known == [None, None]


def test_a_spoilt_lesson_is_told_and_learned_anew(
    analysis: Analysis,
    process: LearnedPairs,
    other_process: LearnedPairs,
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    measure(process)
    (path,) = (tmp_path / "learned").glob("*.npz")
    path.write_bytes(path.read_bytes()[:100])
    measure(other_process)
    assert analysis.known == [None, None]
    assert "learned anew" in caplog.text


def test_a_process_holds_few_lessons_and_reads_the_others_again(
    analysis: Analysis, process: LearnedPairs
) -> None:
    campaigns = [f"campaign {n}" for n in range(6)]
    for name in [*campaigns, *campaigns]:
        measure(process, campaign=name)
    assert analysis.known == [None] * 6 + [0.5] * 6


def test_a_folder_that_cannot_be_written_costs_a_warning_and_no_result(
    analysis: Analysis, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "learned").write_bytes(b"in the way")
    measure(LearnedPairs(tmp_path / "learned"))
    assert analysis.known == [None]
    assert "learn these spheres anew" in caplog.text
