"""One sphere drawn by the simulators, and what the fit is told of it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import as_singles
from analysis.motion.rotation import rotation_matrix
from analysis.photometric.render.camera import Optics
from analysis.photometric.render.pose import fit_pose
from analysis.photometric.render.shading import HARMONICS, RADIALS, blurred_profiles, template
from analysis.photometric.render.sight import Look, Scene, Sight, Stance
from analysis.photometric.render.surface import draw
from simulators.world.disc import SUBPIXELS, Disc
from simulators.world.optics import Lighting

Floats = NDArray[np.float64]

SIZE, RADIUS, ALPHA, REFLECTANCE = 64, 20.0, 0.16, 0.3
BACKGROUND, BRIGHTNESS, LIMB, SIDE, BLUR = 40.0, 140.0, 0.3, 0.1, 0.9
LIGHT = Lighting(BRIGHTNESS, LIMB, SIDE, 0.0, 1.0)
LIMITS = np.array([40.0, 10.0, 6.0, 6.0])
EXPOSED = 9
"""Instants of an exposure that are drawn."""


def drawn(place: Floats, markers: Floats, smear_px: float = 0.0) -> Floats:
    """Return the image without noise; place as (row, column), directions (row, column, eye).

    `smear_px` is how far the sphere moves along the columns while the shutter is open, about
    `place` at its middle.
    """
    if smear_px > 0.0:
        shifts = smear_px * ((np.arange(EXPOSED) + 0.5) / EXPOSED - 0.5)
        instants = np.array([drawn(place + np.array([0.0, s]), markers) for s in shifts])
        smeared: Floats = instants.mean(axis=0)
        return smeared
    canvas = np.full((SIZE * SUBPIXELS,) * 2, BACKGROUND, dtype=np.float32)
    centre = (float(place[0]), float(place[1]))
    Disc(centre, RADIUS, markers, ALPHA, REFLECTANCE, LIGHT).paint(canvas, (0, 0))
    light = canvas.reshape(SIZE, SUBPIXELS, SIZE, SUBPIXELS).mean(axis=(1, 3))
    seen: Floats = cv2.GaussianBlur(light, (0, 0), BLUR).astype(np.float64)
    return seen


def with_noise(image: Floats, noise: float, rng: np.random.Generator) -> NDArray[np.uint8]:
    return np.clip(np.rint(image + noise * rng.normal(size=image.shape)), 0, 255).astype(np.uint8)


def sight_of(
    image: NDArray[np.uint8], markers: Floats, noise: float, smear_px: float = 0.0
) -> Sight:
    """Return the frame with what is known: radius, blur, shading and marker pattern.

    A smear is along the columns, and known as that of a sphere whose track is known.
    """
    shares = {(0, 0, 0): 1 - LIMB, (0, 0, 1): LIMB}
    side = {(1, 1, 0): SIDE * (1 - LIMB), (1, 1, 1): SIDE * LIMB}
    coefficients = [
        BRIGHTNESS
        * (side if sine else shares).get(
            (RADIALS[j].angular, RADIALS[j].power, RADIALS[j].height), 0.0
        )
        for j, sine in HARMONICS
    ]
    wide = float(np.sqrt(BLUR**2 + 1 / 12))
    table = template(blurred_profiles(wide / RADIUS), np.array(coefficients))
    discs, surfaces = draw([table], np.zeros((1, 17, 17)), RADIUS)
    look = Look(
        radius_m=1.0,
        markers=markers,
        alpha=ALPHA,
        darkness=1.0 - REFLECTANCE,
        discs=discs,
        surfaces=surfaces,
        sigma_px=np.array([wide]),
    )
    rows = np.array([[0, SIZE]])
    optics = Optics(np.eye(3)[None], np.zeros((1, 2)), np.array([RADIUS]), np.ones(1), rows)
    background = np.full(image.shape, BACKGROUND)
    shadowed = np.zeros(image.shape, dtype=np.bool_)
    scene = Scene(as_singles(image), background, noise, shadowed)
    motion = np.array([0.0, smear_px / RADIUS, 0.0, 0.0, 0.0, 0.0])
    return Sight(scene, optics, look, np.zeros((1, 0, 3)), motion)


def fitted(sight: Sight, near: Floats, turn: Floats) -> tuple[Stance, Floats]:
    """Fit from a start 0.3 pixels and 1 degree away; return stance and covariance."""
    centre = np.array([*(near + 0.2) / RADIUS, 0.0])
    start = rotation_matrix(np.array([0.01, -0.01, 0.01])) @ turn
    stance = Stance(centre, start, np.array([[0.0, 1.0, 0.0, 0.0]]))
    covariance = np.zeros((6, 6))
    fit_pose(sight, stance, LIMITS, covariance)
    return stance, covariance


def bound(place: Floats, markers: Floats, noise: float, smear_px: float = 0.0) -> Floats:
    """Return the least standard errors of row, column (pixels) and turns (radians)."""
    step = 0.02

    def at(change: Floats) -> Floats:
        return drawn(place + change[:2], markers @ rotation_matrix(change[2:5]).T, smear_px).ravel()

    columns = []
    for k in range(5 if len(markers) else 2):
        change = np.zeros(5)
        change[k] = step
        columns.append((at(change) - at(-change)) / (2 * step))
    y, x = (np.mgrid[:SIZE, :SIZE] - place[:, None, None]) / RADIUS
    disc = np.clip((1 - np.hypot(y, x)) * RADIUS + 0.5, 0, 1)
    columns += [(1 - disc).ravel(), (drawn(place, markers, smear_px) * disc).ravel()]
    columns += [(disc * y).ravel(), (disc * x).ravel()]
    jacobian = np.stack(columns, axis=1)
    covariance = np.linalg.inv(jacobian.T @ jacobian) * (noise**2 + 1 / 12)
    return np.sqrt(np.diag(covariance))[: 5 if len(markers) else 2]
