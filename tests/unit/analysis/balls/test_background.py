"""What stands still: the middle of each pixel, against sorting."""

import numpy as np
import pytest

from analysis.balls.seen.background import background, background_without


@pytest.mark.parametrize("count", [1, 2, 3, 7, 24, 45])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_a_background_is_the_upper_median_of_each_pixel(count: int, kind: type) -> None:
    rng = np.random.default_rng(count)
    frames = rng.integers(0, np.iinfo(kind).max, (count, 5, 7, 3), dtype=kind)
    assert np.array_equal(background(list(frames)), np.sort(frames, axis=0)[count // 2])


def test_frames_in_which_the_ball_hides_a_pixel_do_not_count_for_it() -> None:
    rng = np.random.default_rng(0)
    frames = rng.normal(size=(20, 9, 11)).astype(np.float32)
    hidden = rng.random(frames.shape) < 0.5
    hidden[:, 0, 0] = True
    found = background_without(list(frames), list(hidden))
    for at in np.ndindex(*frames.shape[1:]):
        here = (slice(None), *at)
        seen = frames[here][~hidden[here]] if not hidden[here].all() else frames[here]
        assert found[at] == pytest.approx(np.median(seen), abs=1e-6)
