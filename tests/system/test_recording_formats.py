"""What each rate and format of the recorder tells of a collision; the benchmark has all of them."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.formats import FORMATS, Format, measure

pytestmark = [pytest.mark.long, pytest.mark.timeout(600)]

SPLIT = [recorded for recorded in FORMATS if recorded.pictures > 1]


@pytest.mark.parametrize("recorded", SPLIT, ids=lambda recorded: f"{recorded.pictures} pictures")
def test_split_formats_give_coefficients_within_their_errors(recorded: Format) -> None:
    found = measure(recorded, 3)
    assert len(found.off["e"]) >= 2, found.refused
    assert np.abs(found.off["e"]).max() < 4.0
    assert np.abs(found.off["beta"]).max() < 4.0


def test_at_60_frames_a_second_a_shot_is_refused_with_the_reason() -> None:
    found = measure(Format(60), 2)
    assert found.off["e"] == []
    assert all("needed" in reason or "no markers" in reason for reason in found.refused)
