"""Each format's bytes, put together by hand, come back as the grey levels they hold."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from rigctl.cameras.v4l2_structs import GREY_FORMATS
from rigctl.config import PixelFormatName

PADDING = 4
"""Bytes that a driver adds behind each line."""


def encoded(name: str, levels: np.ndarray) -> np.ndarray:
    """Return lines of bytes as a driver lays them out, levels given in the format's own bits."""
    rows, columns = levels.shape
    if name == "GREY":
        lines = levels.astype(np.uint8)
    elif name in {"YUYV", "UYVY"}:
        lines = np.full((rows, columns * 2), 128, np.uint8)
        for column in range(columns):
            lines[:, 2 * column + (name == "UYVY")] = levels[:, column]
    else:
        lines = np.empty((rows, columns * 2), np.uint8)
        lines[:, 0::2] = levels & 0xFF
        lines[:, 1::2] = levels >> 8
    return np.pad(lines, ((0, 0), (0, PADDING)), constant_values=255)


@pytest.mark.parametrize("name", ["GREY", "YUYV", "UYVY"])
@given(levels=arrays.arrays(np.uint8, st.tuples(st.integers(1, 4), st.integers(1, 6))))
def test_eight_bits_come_back_as_they_are(name: PixelFormatName, levels: np.ndarray) -> None:
    grey = GREY_FORMATS[name].grey(encoded(name, levels), levels.shape[1])
    assert np.array_equal(grey, levels)


@pytest.mark.parametrize(("name", "bits"), [("Y10", 10), ("Y12", 12), ("Y16", 16)])
@given(data=st.data())
def test_more_bits_are_rounded_to_eight(
    name: PixelFormatName, bits: int, data: st.DataObject
) -> None:
    shape = st.tuples(st.integers(1, 4), st.integers(1, 6))
    element = st.integers(0, 2**bits - 1)
    levels = data.draw(arrays.arrays(np.uint16, shape, elements=element))
    grey = GREY_FORMATS[name].grey(encoded(name, levels), levels.shape[1])
    assert grey.dtype == np.uint8
    exact = np.minimum(levels / 2 ** (bits - 8), 255)
    assert np.abs(grey - exact).max() <= 0.5
