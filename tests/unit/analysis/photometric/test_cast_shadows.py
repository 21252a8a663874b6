import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.photometric.follow.cast_shadows import mark_shadows
from analysis.photometric.follow.confirmation import borne_out
from analysis.photometric.render.pose import ONLY, fit_pose
from analysis.photometric.render.sight import Sight, reel_of
from tests.unit.analysis.photometric.drawn import (
    sight_of,
    sphere_image,
    spread_markers,
    stance_at,
)

PLACE, RADIUS, NOISE = (31.3, 32.2), 20.0, 2.0
MARKERS = spread_markers(16, seed=2)
FROM_THE_LEFT = (0.0, -1.5, 1.0)
LIMITS = np.array([6.0, 6.0, 6.0])


def filmed(seed: int, shadow: tuple[float, float, float] | None, left: float = 0.4) -> Sight:
    clear = sphere_image(place=PLACE, radius=RADIUS, markers=MARKERS, shadow=shadow, left=left)
    noisy = clear + np.random.default_rng(seed).normal(0.0, NOISE, clear.shape)
    image = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
    return sight_of(image, MARKERS, radius=RADIUS, noise=NOISE)


def within(circle: tuple[float, float, float], shape: tuple[int, ...], more_px: float) -> NDArray:
    rows, columns = np.indices(shape)
    u, v = (rows - PLACE[0]) / RADIUS, (columns - PLACE[1]) / RADIUS
    reach = circle[2] + more_px / RADIUS
    return np.asarray((u - circle[0]) ** 2 + (v - circle[1]) ** 2 < reach**2)


def fitted_column(sight: Sight) -> float:
    stance = stance_at(*PLACE, RADIUS)
    fit_pose(sight, stance, LIMITS, np.zeros((6, 6)))
    return float(stance.centre[1] * RADIUS)


@pytest.mark.parametrize("shadow", [FROM_THE_LEFT, (0.9, 0.6, 0.7), (0.0, 0.1, 0.4)])
def test_a_shadow_is_marked_with_what_surrounds_it_and_the_rest_is_not(
    shadow: tuple[float, float, float],
) -> None:
    sight = filmed(1, shadow)
    mark_shadows(reel_of(sight, stance_at(*PLACE, RADIUS)), ONLY)
    marked = sight.scene.shadowed
    sphere = within((0.0, 0.0, 1.0), marked.shape, -1.0)
    assert marked[sphere & within(shadow, marked.shape, -1.0)].mean() > 0.97
    assert not marked[~within(shadow, marked.shape, 10.0)].any()


def test_a_sphere_that_looks_as_it_is_known_has_no_shadow() -> None:
    for seed in range(40):
        sight = filmed(seed, None)
        mark_shadows(reel_of(sight, stance_at(*PLACE, RADIUS)), ONLY)
        assert not sight.scene.shadowed.any()


def test_a_shadow_at_the_limb_no_longer_draws_the_centre_away() -> None:
    drawn, kept = [], []
    for seed in range(20):
        sight = filmed(seed, FROM_THE_LEFT, left=0.8)
        drawn.append(fitted_column(sight) - PLACE[1])
        mark_shadows(reel_of(sight, stance_at(*PLACE, RADIUS)), ONLY)
        kept.append(fitted_column(sight) - PLACE[1])
    # One centre scatters by 0.012 pixels, their mean by 0.003.
    assert abs(np.mean(drawn)) > 0.03
    assert abs(np.mean(kept)) < 0.009


def test_a_marker_that_no_frame_shows_is_not_borne_out_and_one_behind_is_not_doubted() -> None:
    # Frames that film the same side; the false marker looks into the camera.
    false = np.array([[0.35, 0.0, np.sqrt(1 - 0.35**2)]])
    far = MARKERS @ false[0] < np.cos(0.4)
    markers = np.concatenate([MARKERS[far], false])
    frames = []
    for seed in range(6):
        clear = sphere_image(place=PLACE, radius=RADIUS, markers=MARKERS[far])
        noisy = clear + np.random.default_rng(seed).normal(0.0, NOISE, clear.shape)
        image = np.clip(np.rint(noisy), 0, 255).astype(np.uint8)
        sight = sight_of(image, markers, radius=RADIUS, noise=NOISE)
        frames.append((sight, stance_at(*PLACE, RADIUS)))
    true = borne_out(frames, len(markers))
    assert true[:-1].all()
    assert not true[-1]
