"""A marked sphere drawn by brute force: sampled points, nothing of the fitted model."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import as_singles
from analysis.photometric.render.camera import Optics
from analysis.photometric.render.shading import HARMONICS, RADIALS, blurred_profiles, template
from analysis.photometric.render.sight import Look, Scene, Sight, Stance
from analysis.photometric.render.surface import draw

SUBPIXELS = 9


def sphere_image(
    *,
    place: tuple[float, float],
    radius: float,
    markers: NDArray[np.float64],
    alpha: float = 0.16,
    size: int = 64,
    blur: float = 0.9,
    side: float = 0.1,
    limb: float = 0.3,
    brightness: float = 140.0,
    background: float = 40.0,
    shadow: tuple[float, float, float] | None = None,
    left: float = 0.4,
) -> NDArray[np.float64]:
    """Return the image, shape (size, size), of a sphere in front of an even background.

    Side light along the columns; markers are 70 per cent darker; directions (row, column, eye). A
    shadow leaves a part of the light: row, column and radius of a circle, in radii from the
    sphere's centre.
    """
    fine = (np.arange(size * SUBPIXELS) + 0.5) / SUBPIXELS - 0.5
    v, u = np.meshgrid((fine - place[1]) / radius, (fine - place[0]) / radius)
    square = u**2 + v**2
    inside = square < 1.0
    height = np.sqrt(np.clip(1.0 - square, 0.0, None))
    shade = brightness * (1.0 - limb * square) * (1.0 + side * v)
    for marker in markers:
        covered = u * marker[0] + v * marker[1] + height * marker[2] > np.cos(alpha)
        shade = np.where(covered, 0.3 * shade, shade)
    if shadow is not None:
        in_shadow = (u - shadow[0]) ** 2 + (v - shadow[1]) ** 2 < shadow[2] ** 2
        shade = np.where(in_shadow, left * shade, shade)
    scene = np.where(inside, shade, background)
    soft = cv2.GaussianBlur(scene, (0, 0), blur * SUBPIXELS)
    return soft.reshape(size, SUBPIXELS, size, SUBPIXELS).mean(axis=(1, 3))


def spread_markers(number: int, seed: int) -> NDArray[np.float64]:
    """Return directions at least 0.55 radians apart, shape (number, 3)."""
    rng = np.random.default_rng(seed)
    chosen: list[NDArray[np.float64]] = []
    while len(chosen) < number:
        trial = rng.normal(size=3)
        trial /= np.linalg.norm(trial)
        if all(trial @ other < np.cos(0.55) for other in chosen):
            chosen.append(trial)
    return np.array(chosen)


def sight_of(
    image: NDArray[np.uint8],
    markers: NDArray[np.float64],
    *,
    radius: float,
    noise: float,
    alpha: float = 0.16,
    blur: float = 0.9,
    side: float = 0.1,
    limb: float = 0.3,
    brightness: float = 140.0,
    background: float = 40.0,
) -> Sight:
    """Return the sight of such a sphere in one view, metres being radii and its look known."""
    wide = float(np.hypot(blur, 12**-0.5))
    coefficients = np.zeros(len(HARMONICS))
    for (j, sine), index in zip(HARMONICS, range(len(HARMONICS)), strict=True):
        radial = RADIALS[j]
        if radial.height == 0 and radial.angular == 0:
            coefficients[index] = {0: brightness, 2: -brightness * limb}.get(radial.power, 0.0)
        if radial.height == 0 and radial.angular == 1 and sine:
            strength = {1: brightness * side, 3: -brightness * limb * side}
            coefficients[index] = strength.get(radial.power, 0.0)
    table = template(blurred_profiles(wide / radius), coefficients)
    discs, surfaces = draw([table], np.zeros((1, 17, 17)), radius)
    look = Look(
        radius_m=1.0,
        markers=np.asarray(markers, dtype=np.float64).reshape(-1, 3),
        alpha=alpha,
        darkness=0.7,
        discs=discs,
        surfaces=surfaces,
        sigma_px=np.array([wide]),
    )
    optics = Optics(
        axes=np.eye(3)[None],
        origins=np.zeros((1, 2)),
        scales=np.array([radius]),
        hands=np.ones(1),
        rows=np.array([[0, len(image)]]),
    )
    still, shadowed = np.full(image.shape, background), np.zeros(image.shape, bool)
    scene = Scene(as_singles(image), still, noise, shadowed)
    return Sight(scene, optics, look, np.zeros((1, 0, 3)), np.zeros(6))


def stance_at(row: float, column: float, radius: float) -> Stance:
    """Return a stance of the identity's orientation at a pixel, metres being radii."""
    centre = np.array([row / radius, column / radius, 0.0])
    return Stance(centre, np.eye(3), np.array([[0.0, 1.0, 0.0, 0.0]]))


def with_noise(image: NDArray[np.float64], noise: float, seed: int) -> NDArray[np.uint8]:
    """Return the image with read noise, rounded to 8 bit."""
    rng = np.random.default_rng(seed)
    return np.clip(np.rint(image + noise * rng.normal(size=image.shape)), 0, 255).astype(np.uint8)
