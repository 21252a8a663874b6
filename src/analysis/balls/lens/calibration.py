"""A lens from pictures of a board held at several angles.

Z. Zhang, IEEE Trans. Pattern Anal. Mach. Intell. 22, 1330 (2000), by OpenCV. Its standard errors
take all corners for independent; those of one picture are not (the board is not quite flat, the
picture is smeared). Errors here are the larger of its own and those of leaving out one group of
pictures at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from analysis.arrays import Floats
from analysis.balls.films.film import Picture
from analysis.balls.films.reading import open_film
from analysis.balls.lens.board import Board, BoardFinder, Grey, SeenBoard
from analysis.balls.lens.lens import Lens
from analysis.errors import InputError

MOST_PICTURES = 120
"""Of a longer film, as many are looked at, evenly over it."""
LEAST_VIEWS, MOST_VIEWS = 5, 40
NEW_VIEW = 0.02
"""Mean shift of corners, of the picture's width, that makes another view."""
GROUPS = 8
LEAST_PERSPECTIVE = 0.05
"""Relative standard error of the focal length above which it is not determined."""
DETERMINED = 2.0
"""Standard errors from which k2 is kept; else it is 0."""
_FIXED = cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST


@dataclass(frozen=True, slots=True, eq=False)
class LensCalibration:
    """A calibrated lens, and how it was found.

    Attributes
    ----------
    lens
        The result.
    used
        Numbers of the pictures whose corners were used.
    looked_at
        How many pictures were looked at.
    rms_px
        Distance of corners from where the lens sees them.
    covered
        Share of the picture's half diagonal up to which corners were seen: farther out the
        distortion is extrapolated.
    """

    lens: Lens
    used: tuple[int, ...]
    looked_at: int
    rms_px: float
    covered: float


def calibrate_lens(
    path: Path, board: Board, progress: Callable[[int, int], None] | None = None
) -> LensCalibration:
    """Calibrate the lens that filmed a board.

    Parameters
    ----------
    path
        A film, or a folder of pictures.
    progress
        Called with how many pictures have been looked at, and of how many.

    Raises
    ------
    InputError
        The film cannot be read, the board is seen in fewer than five different views, or only ever
        flat to the camera.
    """
    film = open_film(path)
    size = film.head.height, film.head.width
    count = min(film.head.frames, MOST_PICTURES)
    chosen = set(np.linspace(0, film.head.frames - 1, count).round().astype(int).tolist())
    finder, looked_at = BoardFinder(board), 0
    views: list[tuple[int, SeenBoard]] = []
    for number, picture in enumerate(film.pictures()):
        if number not in chosen:
            continue
        looked_at += 1
        seen = finder.find(_grey(picture))
        if seen is not None and _is_new(seen, [view for _, view in views], size[1]):
            views.append((number, seen))
        if progress is not None:
            progress(looked_at, len(chosen))
    if len(views) < LEAST_VIEWS:
        raise InputError(
            path,
            f"a board of {board.columns} x {board.rows} inner corners is seen in {len(views)} "
            f"different views of {looked_at} pictures; {LEAST_VIEWS} are needed: hold it at other "
            "angles and places, whole and sharp, and check the number of inner corners",
        )
    kept = sorted({int(k) for k in np.linspace(0, len(views) - 1, MOST_VIEWS)})
    seen_boards = [views[k][1] for k in kept]
    values, sigmas, rms = _with_errors(seen_boards, size, _FIXED)
    if abs(values[5]) < DETERMINED * sigmas[5]:
        # Views near the middle do not separate k2 from k1, and beyond them it grows with r^5. What
        # it would have changed is part of the errors.
        free = values
        values, sigmas, rms = _with_errors(seen_boards, size, _FIXED | cv2.CALIB_FIX_K2)
        sigmas = np.hypot(sigmas, values - free)
    lens = _lens(values, sigmas, size)
    if lens.focal_sigma_px > LEAST_PERSPECTIVE * min(lens.focal_px):
        raise InputError(
            path,
            f"the focal length is not determined: {min(lens.focal_px):.0f} +- "
            f"{lens.focal_sigma_px:.0f} px; tilt the board against the camera by 30 to 45 degrees",
        )
    used = tuple(views[k][0] for k in kept)
    return LensCalibration(lens, used, looked_at, rms, _covered(seen_boards, lens))


def _grey(picture: Picture) -> Grey:
    """Return a picture in 8 bits; its brightest pixels become white."""
    light = picture.astype(np.float32).mean(axis=2)
    white = max(float(np.quantile(light, 0.999)), 1.0)
    return np.asarray(np.clip(light * (255.0 / white), 0, 255).astype(np.uint8))


def _is_new(seen: SeenBoard, others: Sequence[SeenBoard], width: int) -> bool:
    """Return whether corners lie elsewhere than in every view so far."""
    for other in others:
        if len(other.in_picture) != len(seen.in_picture):
            continue
        shift = np.linalg.norm(other.in_picture - seen.in_picture, axis=1).mean()
        if shift < NEW_VIEW * width:
            return False
    return True


def _with_errors(
    views: Sequence[SeenBoard], size: tuple[int, int], flags: int
) -> tuple[Floats, Floats, float]:
    """Return what `_fit` does, errors never below those of leaving out views (jackknife)."""
    values, sigmas, rms = _fit(views, size, flags)
    groups = min(GROUPS, len(views) - 2)
    without = [
        _fit([view for k, view in enumerate(views) if k % groups != group], size, flags)[0]
        for group in range(groups)
    ]
    return values, np.maximum(sigmas, np.std(without, axis=0) * np.sqrt(groups - 1)), rms


def _fit(
    views: Sequence[SeenBoard], size: tuple[int, int], flags: int
) -> tuple[Floats, Floats, float]:
    """Return fx, fy, cx, cy, k1, k2 and the shift of a corner, px, their errors, and the rms, px.

    Shapes (7,); the corner's own error is left to leaving out.
    """
    rms, matrix, distortion, _, _, sigmas, _, _ = cv2.calibrateCameraExtended(
        [view.on_board.astype(np.float32) for view in views],
        [view.in_picture.astype(np.float32) for view in views],
        (size[1], size[0]),
        np.eye(3),
        np.zeros(5),
        flags=flags,
    )
    fx, fy, cx, cy = matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]
    k1, k2 = np.ravel(distortion)[:2]
    ends = [(x, y) for x in (0.0, size[1] - 1.0) for y in (0.0, size[0] - 1.0)]
    radius = max(float(np.hypot((x - cx) / fx, (y - cy) / fy)) for x, y in ends)
    corner = 0.5 * (fx + fy) * (k1 * radius**3 + k2 * radius**5)
    values = np.array([fx, fy, cx, cy, k1, k2, corner], np.float64)
    return values, np.append(np.ravel(sigmas)[:6], 0.0), float(rms)


def _lens(values: Floats, sigmas: Floats, size: tuple[int, int]) -> Lens:
    fx, fy, cx, cy, k1, k2, corner = map(float, values)
    return Lens(
        height_px=size[0],
        width_px=size[1],
        focal_px=(fy, fx),
        centre_px=(cy, cx),
        k1=k1,
        k2=k2,
        focal_sigma_px=float(max(sigmas[:2])),
        k1_sigma=float(sigmas[4]),
        k2_sigma=float(sigmas[5]),
        corner_px=corner,
        corner_sigma_px=float(sigmas[6]),
    )


def _covered(views: Sequence[SeenBoard], lens: Lens) -> float:
    row, column = lens.centre_px
    far = max(float(np.hypot(*(view.in_picture - (column, row)).T).max()) for view in views)
    return min(1.0, far / (0.5 * float(np.hypot(lens.height_px, lens.width_px))))
