"""Centres by the circles of other libraries."""

from __future__ import annotations

import importlib
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Locate = Callable[[NDArray[np.uint8]], Floats]


def hough(image: NDArray[np.uint8]) -> Floats:
    found = cv2.HoughCircles(
        image, cv2.HOUGH_GRADIENT_ALT, 1, 30, param1=100, param2=0.6, minRadius=15, maxRadius=25
    )
    return np.full(2, np.nan) if found is None else np.asarray(found[0, 0, 1::-1], dtype=np.float64)


def enclosing(image: NDArray[np.uint8]) -> Floats:
    _, mask = cv2.threshold(image, 0, 255, cv2.THRESH_OTSU)
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    (x, y), _ = cv2.minEnclosingCircle(max(outlines, key=len))
    return np.array([y, x])


def others() -> dict[str, Locate]:
    """Return the methods to compare with, of the libraries that are installed."""
    methods: dict[str, Locate] = {"OpenCV Hough": hough, "OpenCV enclosing circle": enclosing}
    for name, build in (("skimage", _skimage), ("trackpy", _trackpy)):
        try:
            methods[name] = build(importlib.import_module(name))
        except ImportError:
            print(f"{name} is not installed; python -m pip install scikit-image trackpy has both")
    return methods


def _skimage(_: object) -> Locate:
    feature = importlib.import_module("skimage.feature")
    transform = importlib.import_module("skimage.transform")

    def locate(image: NDArray[np.uint8]) -> Floats:
        radii = np.arange(18, 23)
        votes = transform.hough_circle(feature.canny(image, 2.0), radii)
        _, x, y, _ = transform.hough_circle_peaks(votes, radii, total_num_peaks=1)
        return np.array([y[0], x[0]], dtype=np.float64)

    return locate


def _trackpy(library: object) -> Locate:
    def locate(image: NDArray[np.uint8]) -> Floats:
        found = library.locate(image, 45, preprocess=False, topn=1)  # type: ignore[attr-defined]
        return np.asarray(found[["y", "x"]].to_numpy()[0]) if len(found) else np.full(2, np.nan)

    return locate
