import numpy as np
import pytest

from analysis.errors import ShotRefusedError
from analysis.motion.poses import Centres
from analysis.motion.split import split_at_contact

G = 9.80665
TIMES = np.arange(16) * 1e-3
SIGMA = 2e-5


def track(
    before: tuple[float, float, float],
    after: tuple[float, float, float],
    first_after: int,
    *,
    frames: np.ndarray | None = None,
    seed: int = 0,
) -> Centres:
    """Return noisy centres that kink half a frame before `first_after` and fall throughout."""
    shown = np.arange(16) if frames is None else frames
    kink = (first_after - 0.5) * 1e-3
    tau = TIMES[shown, None] - kink
    straight = np.where(tau < 0, np.array(before) * tau, np.array(after) * tau)
    straight = straight + 0.5 * G * np.array([1.0, 0.0, 0.0]) * TIMES[shown, None] ** 2
    noise = SIGMA * np.random.default_rng(seed).standard_normal(straight.shape)
    return Centres(shown, straight + noise, np.full(straight.shape, SIGMA))


@pytest.mark.parametrize("first_after", range(3, 14))
def test_the_first_frame_after_the_kink_is_found(first_after: int) -> None:
    a = track((0.0, 2.0, 0.0), (-0.3, -1.4, 0.0), first_after, seed=1)
    b = track((0.0, -2.0, 0.0), (0.3, 1.4, 0.0), first_after, seed=2)
    assert split_at_contact(a, b, TIMES, G) == first_after


def test_frames_that_miss_a_sphere_do_not_count() -> None:
    seen = np.array([0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 15])
    a = track((0.0, 2.0, 0.0), (0.0, -1.4, 0.0), 7, frames=seen, seed=1)
    b = track((0.0, -2.0, 0.0), (0.0, 1.4, 0.0), 7, seed=2)
    assert split_at_contact(a, b, TIMES, G) == 8


def test_tracks_without_a_kink_are_refused() -> None:
    a = track((0.0, 2.0, 0.0), (0.0, 2.0, 0.0), 8, seed=1)
    b = track((0.0, -2.0, 0.0), (0.0, -2.0, 0.0), 8, seed=2)
    with pytest.raises(ShotRefusedError, match=r"contact: .*no contact.*frames 0 and 15"):
        split_at_contact(a, b, TIMES, G)


def test_falling_is_no_kink() -> None:
    still = track((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 8, seed=3)
    with pytest.raises(ShotRefusedError, match="run straight"):
        split_at_contact(still, still, TIMES, G)
    # Without gravity the same parabola bends away from one straight line.
    assert 5 <= split_at_contact(still, still, TIMES, 0.0) <= 11


def test_fewer_than_six_common_frames_are_refused_with_their_number() -> None:
    a = track((0.0, 2.0, 0.0), (0.0, -1.4, 0.0), 3, frames=np.arange(0, 9))
    b = track((0.0, -2.0, 0.0), (0.0, 1.4, 0.0), 3, frames=np.arange(4, 16))
    with pytest.raises(ShotRefusedError, match=r"measured in 5 frames; 6 are needed"):
        split_at_contact(a, b, TIMES, G)
