"""Images with every fault a camera can have: an honest answer, or a refusal that says why.

Never a wrong pose with a small error. Faults are drawn at random over shots of two pairs; the
truth is that of the simulators.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.teaching import teach
from analysis.setup import Setup
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot, analyse_shot
from simulators.world import Launch, RenderedShot, WorldDescription, render_shot
from simulators.world.description import Sphere
from simulators.world.lamp import Lamp
from simulators.world.optics import Optics
from tests.unit.analysis.rendered import setup_of

OPTIONS = AnalysisOptions(method="photometric")
OPTICS = Optics(exposure_s=0.0)
LIT_FROM_THE_SIDE = replace(OPTICS, lamp=Lamp(gloss=60.0), distance_m=0.92)
LAUNCH, SEED, FRAMES = Launch(55.0, 55.0, 0.006), 11, 16

MOST_SIGMAS = 6.0
SHIFT_PX = 0.25
"""Light that is not what was learned shifts all discs alike by some tenth of a pixel."""
E_ALWAYS, V_N_ALWAYS = 0.003, 0.003
"""Errors in e, and relative ones in v_n, that are never called wrong."""

few = settings(
    max_examples=4,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


@dataclass(frozen=True)
class Filmed:
    shot: RenderedShot
    setup: Setup
    known: Appearance


def filmed(optics: Optics) -> Filmed:
    world = WorldDescription(optics=optics)
    shot = render_shot(world, LAUNCH, SEED, frames=FRAMES)
    setup = setup_of(world)
    known = teach([(shot.frames, shot.times_s, setup)])
    assert known is not None
    return Filmed(shot, setup, known)


LIGHTS = [
    pytest.param(OPTICS, id="plain"),
    pytest.param(LIT_FROM_THE_SIDE, id="side light", marks=pytest.mark.long),
]


@pytest.fixture(scope="module", params=LIGHTS)
def film(request: pytest.FixtureRequest) -> Filmed:
    return filmed(request.param)


def measured(
    film: Filmed, frames: NDArray[np.uint8], *, learn: bool = False
) -> MeasuredShot | RefusedShot:
    times_s = film.shot.times_s[: len(frames)]
    return analyse_shot(frames, times_s, film.setup, OPTIONS, None if learn else film.known)


def refused_with_reason(shot: MeasuredShot | RefusedShot) -> bool:
    return isinstance(shot, RefusedShot) and bool(shot.step) and len(shot.reason) > 10


def honest(shot: MeasuredShot | RefusedShot, rendered: RenderedShot) -> bool:
    """Tell whether an answer is a refusal with a reason, or right within what it states."""
    if not isinstance(shot, MeasuredShot):
        return refused_with_reason(shot)
    truth, impact = rendered.truth, shot.impact
    e_off = abs(impact.e.value + truth["v_n_after"] / truth["v_n"])
    v_n_off = abs(impact.v_n.value / truth["v_n"] - 1.0)
    v_n_sigma = impact.v_n.sigma / abs(truth["v_n"])
    return (
        e_off < max(MOST_SIGMAS * impact.e.sigma, E_ALWAYS)
        and v_n_off < max(MOST_SIGMAS * v_n_sigma, V_N_ALWAYS)
        and worst_place(shot, rendered) < 1.0
    )


def worst_place(shot: MeasuredShot, rendered: RenderedShot) -> float:
    """Return the largest error of a disc in the front view over what is allowed for it."""
    worst = 0.0
    for i, sphere in enumerate(shot.tracking.spheres):
        front = next(iter(sphere.values()))
        for k, outline in front.outlines.items():
            true = rendered.truth["centres_front_px"][k][i]
            if true is None:
                continue
            sigma = np.sqrt(np.diag(outline.circle.covariance)[:2])
            off = np.array([outline.circle.row, outline.circle.column]) - true
            worst = max(worst, float((np.abs(off) / (SHIFT_PX + MOST_SIGMAS * sigma)).max()))
    return worst


def test_the_shot_itself_is_measured(film: Filmed) -> None:
    shot = measured(film, film.shot.frames)
    assert isinstance(shot, MeasuredShot)
    assert honest(shot, film.shot)


@few
@given(full=st.integers(90, 255), learn=st.booleans())
def test_a_full_well_is_no_wrong_pose(film: Filmed, full: int, learn: bool) -> None:
    frames = np.minimum(film.shot.frames, np.uint8(full))
    assert honest(measured(film, frames, learn=learn), film.shot)


def test_discs_that_are_mostly_cut_off_cannot_be_learned(film: Filmed) -> None:
    shot = measured(film, np.minimum(film.shot.frames, np.uint8(80)), learn=True)
    assert isinstance(shot, RefusedShot)
    assert "full at grey level 80" in shot.reason


@few
@given(
    rows=st.lists(st.integers(0, 191), min_size=1, max_size=3),
    grey=st.sampled_from([0, 40, 255]),
    learn=st.booleans(),
)
def test_dead_rows_are_no_wrong_pose(film: Filmed, rows: list[int], grey: int, learn: bool) -> None:
    frames = film.shot.frames.copy()
    frames[:, rows] = grey
    assert honest(measured(film, frames, learn=learn), film.shot)


@few
@given(
    down=st.floats(-0.5, 0.5),
    across=st.floats(-0.5, 0.5),
    flicker=st.floats(0.0, 0.1),
    learn=st.booleans(),
)
def test_uneven_and_flickering_light_is_no_wrong_pose(
    film: Filmed, down: float, across: float, flicker: float, learn: bool
) -> None:
    rows, columns = np.mgrid[-1.0:1.0:192j, -1.0:1.0:240j]
    blinks = 1.0 + flicker * np.sin(np.arange(FRAMES))[:, None, None]
    light = film.shot.frames * (1.0 + down * rows + across * columns) * blinks
    frames = np.clip(np.rint(light), 0, 255).astype(np.uint8)
    assert honest(measured(film, frames, learn=learn), film.shot)


@few
@given(lost=st.integers(3, FRAMES - 4), learn=st.booleans())
def test_a_dropped_frame_is_refused_or_does_no_harm(film: Filmed, lost: int, learn: bool) -> None:
    shot = measured(film, np.delete(film.shot.frames, lost, axis=0), learn=learn)
    if isinstance(shot, RefusedShot):
        assert refused_with_reason(shot)
        return
    # Next to the contact a lost frame is a longer contact: its instant is known no better.
    truth = film.shot.truth
    assert abs(shot.impact.e.value + truth["v_n_after"] / truth["v_n"]) < 0.01
    assert abs(shot.impact.contact_time.value - truth["contact_time_s"]) < 1.1e-3


@few
@given(again=st.integers(3, FRAMES - 4), learn=st.booleans())
def test_a_repeated_frame_is_refused_or_named_and_left_out(
    film: Filmed, again: int, learn: bool
) -> None:
    frames = film.shot.frames.copy()
    frames[again] = frames[again - 1]
    shot = measured(film, frames, learn=learn)
    if isinstance(shot, RefusedShot):
        assert refused_with_reason(shot)
        return
    assert again not in (*shot.used_before, *shot.used_after)
    assert any(note.startswith(f"frame {again} left out") for note in shot.notes)
    assert honest(shot, film.shot)


@few
@given(covered=st.integers(20, 110), side=st.sampled_from(["left", "right"]), learn=st.booleans())
def test_a_sphere_half_out_of_view_is_no_wrong_pose(
    film: Filmed, covered: int, side: str, learn: bool
) -> None:
    frames = film.shot.frames.copy()
    hidden = np.s_[..., :covered] if side == "left" else np.s_[..., -covered:]
    frames[hidden] = 33
    assert honest(measured(film, frames, learn=learn), film.shot)


@pytest.mark.parametrize("markers", [0, 1])
def test_spheres_with_too_few_markers_are_measured_without_their_spins(markers: int) -> None:
    sphere = Sphere(markers=markers)
    world = WorldDescription(sphere_a=sphere, sphere_b=sphere, optics=OPTICS)
    rendered = render_shot(world, LAUNCH, SEED, frames=FRAMES)
    shot = analyse_shot(rendered.frames, rendered.times_s, setup_of(world), OPTIONS)
    assert isinstance(shot, MeasuredShot)
    assert shot.impact.v_s is None
    assert "spins are open" in shot.notes[0]
    assert honest(shot, rendered)


def test_other_spheres_are_not_taken_for_those_that_were_learned(film: Filmed) -> None:
    world = WorldDescription(optics=OPTICS)
    other = render_shot(world, LAUNCH, SEED + 1, frames=FRAMES)
    assert honest(measured(film, other.frames), other)


def magnified(times: float) -> Optics:
    """Return optics whose frames, and the spheres in them, are so many times larger."""
    row, column = OPTICS.front_origin_px
    top, boundary = OPTICS.top_origin_px[0], OPTICS.front_rows[0]
    return replace(
        OPTICS,
        rows=round(OPTICS.rows * times),
        columns=round(OPTICS.columns * times),
        scale_px_per_m=OPTICS.scale_px_per_m * times,
        front_origin_px=(row * times, column * times),
        top_origin_px=(top * times, column * times),
        front_rows=(round(boundary * times), round(OPTICS.rows * times)),
        top_rows=(0, round(boundary * times)),
    )


@pytest.mark.long
def test_the_scale_of_spheres_of_ten_pixels_radius_is_as_uncertain_as_stated() -> None:
    world = WorldDescription(optics=magnified(0.5))
    setup = setup_of(world)
    setup = replace(setup, camera=replace(setup.camera, scale_px_per_m=None))
    off = []
    for seed in range(8):
        film = render_shot(world, Launch(30.0 + 4 * seed, 30.0 + 4 * seed, 0.006), seed)
        known = teach([(film.frames, film.times_s, setup)])
        assert known is not None
        true = world.optics.scale_px_per_m
        off.append((known.camera.optics.scales[0] / true - 1.0) / known.scale_sigma)
    assert 0.4 < np.sqrt(np.mean(np.square(off))) < 1.5
    assert np.abs(off).max() < 3.5


@pytest.mark.parametrize("diameter_px", [12, pytest.param(120, marks=pytest.mark.long)])
@pytest.mark.parametrize("stated", [True, False], ids=["scale stated", "scale unknown"])
def test_small_and_large_spheres_are_measured_or_refused(diameter_px: int, stated: bool) -> None:
    optics = magnified(diameter_px / 40.0)
    world = WorldDescription(optics=optics)
    rendered = render_shot(world, LAUNCH, SEED, frames=10)
    setup = setup_of(world)
    if not stated:
        setup = replace(setup, camera=replace(setup.camera, scale_px_per_m=None))
    shot = analyse_shot(rendered.frames, rendered.times_s, setup, OPTIONS)
    assert honest(shot, rendered)
