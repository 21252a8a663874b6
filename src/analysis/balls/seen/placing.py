"""Places of a known ball in the frames of a film, from every pixel's light about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis import threads
from analysis.arrays import Floats
from analysis.balls.seen.misfits import (
    RADII,
    about,
    falls_to,
    least,
    together,
    unsure,
)
from analysis.balls.seen.patches import CHANCE, LEFT, fit_outline
from analysis.balls.seen.photometry import (
    GROUND,
    LAYERS,
    LEAST_COVER,
    LIGHT,
    MAP_SIDE,
    RADIUS,
    RESIDUAL,
    TERMS,
    WEIGHT,
    add_light,
    cover,
    fit_place,
)
from analysis.balls.seen.windows import Motion, Window

Ints = NDArray[np.intp]

BLURS = (0.4, 0.6, 0.85, 1.2, 1.7, 2.4)
LEAST_OUTLINE = 1
"""Which of them an outline has at least: patches make up for one that is too sharp."""
MUCH_BETTER, MUCH_LARGER = 0.7, 0.12
OUTLINES, OUTLINED = (0.84, 0.88, 0.92, 0.96, 1.0, 1.04, 1.08, 1.12, 1.16), 12
"""In radii of the rim, of a ball with patches, and the frames that tell."""
EXPOSURES = (0.0, 0.03, 0.08, 0.15, 0.25, 0.4, 0.6, 0.8, 0.98)
"""In times between frames."""
SLOW_FRAMES, MORE_SLOW, FAST_FRAMES = 6, 4, 4
TOLD_SMEAR_PX = 1.5
"""A change of the smear by less is not told from blur."""
TEACHING_FRAMES = 100
"""At least so many of a film's frames teach the ball's light, where it has as many."""
LEAST_CELL = 3.0
"""Weight of a cell of the learned light that counts."""
FURTHEST_RADII = 0.8
"""A fit that has moved further from where the ball was seen is none."""


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Fitted places.

    Attributes
    ----------
    frames, places, sigmas
        Shapes (N,), (N, 2), (N, 2).
    misfits
        Mean square of what each fit leaves about the ball, shape (N,).
    left
        Sum of squares of what it leaves in all of its window, shape (N,): about another radius the
        ball covers other pixels of the same window.
    larger
        By how much the ball was taken to be larger than its radius, relative, shape (N,).
    """

    frames: Ints
    places: Floats
    sigmas: Floats
    misfits: Floats
    left: Floats
    larger: Floats

    def of(self, chosen: NDArray[np.bool_]) -> Placed:
        """Return some of them."""
        parts = (self.places, self.sigmas, self.misfits, self.left, self.larger)
        return Placed(self.frames[chosen], *(each[chosen] for each in parts))


@dataclass(slots=True, eq=False)
class Placer:
    """Fits places of one ball in windows; it learns blur, exposure and the ball's own light.

    Attributes
    ----------
    radius_px
        Held.
    blur_px
        Of a rim, in pixels of the windows.
    exposure_s
        Time the shutter is open.
    table
        Light of the ball beyond a smooth shading, shape (MAP_SIDE, MAP_SIDE).
    patched
        Whether it shows other patches in each frame: its outline alone is fitted, no light learned.
    chance
        What it costs that such a ball is somewhere as light as the ground.
    """

    radius_px: float
    blur_px: float
    exposure_s: float
    table: Floats
    patched: bool = False
    chance: float = CHANCE
    _exposure_told: bool = False

    @classmethod
    def new(cls, radius_px: float, exposure_s: float, *, patched: bool = False) -> Placer:
        """Return one that has learned nothing."""
        return cls(radius_px, 1.0, exposure_s, np.zeros((MAP_SIDE, MAP_SIDE)), patched)

    def learn_blur(self, windows: Sequence[Window], motion: Motion) -> None:
        """Take the blur that explains the slowest frames best."""
        chosen = self._slow(windows, motion)

        def misfits(blur: float) -> Floats:
            self.blur_px = blur
            return self._misfits(chosen, motion)

        tried = BLURS[LEAST_OUTLINE:] if self.patched else BLURS
        self.blur_px = least(together(misfits, tried), tried)

    def learn_radius(self, windows: Sequence[Window], motion: Motion) -> bool:
        """Take a radius that explains the slowest frames much better than the rim's, if any does.

        A ball whose far side is as dark as the ground shows a rim that is not its own. Its misfit
        falls steadily up to the right radius; where it rises between, something beside the ball is
        explained.
        """
        if self.patched:
            return self._learn_outline(windows, motion)
        chosen = self._slow(windows, motion)
        rim = self.radius_px

        def misfit(factor: float) -> float:
            self.radius_px = factor * rim
            self._fits(chosen, motion, 0.0)
            whole = [float((window.pixels[RESIDUAL] ** 2).sum()) for window in chosen]
            return float(np.median(whole))

        best = least(misfit, RADII)
        much = misfit(best) < MUCH_BETTER * misfit(1.0) and abs(best - 1.0) > MUCH_LARGER
        much = much and falls_to(best, [misfit(factor) for factor in RADII])
        self.radius_px = best * rim if much else rim
        return much

    def _learn_outline(self, windows: Sequence[Window], motion: Motion) -> bool:
        """Take the radius that explains the slowest frames of a ball with patches best.

        Discs are found by edges, which patches have within the rim.
        """
        slow = self._by_speed(windows, motion)[: MORE_SLOW * SLOW_FRAMES]
        chosen = slow[:: max(1, len(slow) // OUTLINED)]
        rim = self.radius_px

        def misfits(factor: float) -> Floats:
            self.radius_px = factor * rim
            return self._misfits(chosen, motion)

        best = least(together(misfits, OUTLINES), OUTLINES)
        self.radius_px = best * rim
        return best != 1.0

    def learn_exposure(
        self, windows: Sequence[Window], motion: Motion, period_s: float
    ) -> tuple[float, float] | None:
        """Take the exposure that explains the fastest frames best.

        Returns
        -------
        Exposure and its standard error in s, that of none at all where the fastest frames show no
        smear: how long it may be all the same. None where smears are too short to tell.
        """
        chosen = self._by_speed(windows, motion)[-2 * FAST_FRAMES :]
        speeds = np.hypot(*motion.speeds.T)
        fastest = float(np.sort(speeds)[-FAST_FRAMES:].mean())
        if fastest * period_s < 2 * TOLD_SMEAR_PX:
            self.exposure_s = min(self.exposure_s, period_s)
            return None

        def misfits(exposure: float) -> Floats:
            self.exposure_s = exposure
            return self._misfits(chosen, motion)

        whole = [share * period_s for share in EXPOSURES]
        near = about(whole, self.exposure_s) if self._exposure_told else whole
        misfit = together(misfits, near)
        found = least(misfit, near)
        if found in (near[0], near[-1]) and found not in (whole[0], whole[-1]):
            misfit = together(misfits, whole)
            found = least(misfit, whole)
        error = unsure(misfit, whole, found)
        self.exposure_s, self._exposure_told = found, True
        smear = TOLD_SMEAR_PX / fastest / np.sqrt(min(len(chosen), FAST_FRAMES))
        return found, max(error, float(smear))

    def _slow(self, windows: Sequence[Window], motion: Motion) -> list[Window]:
        """Return those of the slowest frames that are explained best.

        A hand that lets the ball go covers part of its rim in the slowest frames of all.
        """
        slow = self._by_speed(windows, motion)[: MORE_SLOW * SLOW_FRAMES]
        fits = self._fits(slow, motion, 0.0)
        order = np.argsort([fit[4] if fit[5] > 0 else np.inf for _, fit, _ in fits])
        return [slow[k] for k in order[:SLOW_FRAMES]]

    def _by_speed(self, windows: Sequence[Window], motion: Motion) -> list[Window]:
        sizes = np.hypot(*motion.speeds.T).tolist()
        speed = dict(zip(motion.frames.tolist(), sizes, strict=True))
        return sorted(windows, key=lambda window: speed[window.frame])

    def _misfits(self, windows: Sequence[Window], motion: Motion) -> Floats:
        """Return the sum of squares that each window's fit leaves; infinite where it fails.

        All pixels of a window count whatever the ball covers of them: a mean over what it covers
        is least for the widest rim and the longest smear.
        """
        found = np.full(len(windows), np.inf)
        for k, (_, fit, _) in enumerate(self._fits(windows, motion, 0.0)):
            if fit[5] > 0:
                found[k] = fit[LEFT]
        return found

    def place(self, windows: Sequence[Window], motion: Motion, row_time_s: float = 0.0) -> Placed:
        """Fit the ball in each window; frames in which it is not where it is expected drop out."""
        frames, places, sigmas, misfits, left, larger = [], [], [], [], [], []
        for window, fit, pose in self._fits(windows, motion, row_time_s):
            if fit[5] <= 0 or window.factor * fit[6] > FURTHEST_RADII * self.radius_px:
                continue
            frames.append(window.frame)
            places.append(window.outward(fit[:2]))
            sigmas.append(window.factor * fit[2:4])
            misfits.append(fit[4])
            left.append(fit[LEFT])
            larger.append(window.factor * pose[RADIUS] / self.radius_px - 1.0)
        return Placed(
            np.array(frames, dtype=np.intp),
            np.array(places).reshape(-1, 2),
            np.maximum(np.array(sigmas).reshape(-1, 2), 1e-4),
            np.array(misfits, dtype=np.float64),
            np.array(left, dtype=np.float64),
            np.array(larger, dtype=np.float64),
        )

    def learn_light(
        self, windows: Sequence[Window], motion: Motion, row_time_s: float = 0.0
    ) -> None:
        """Learn what the smooth shading leaves of the ball's light, from all frames together."""
        if self.patched:
            return
        sums = np.zeros((2, MAP_SIDE, MAP_SIDE))
        for window, fit, pose in self._fits(_teaching(windows), motion, row_time_s):
            if fit[5] <= 0 or window.factor * fit[6] > FURTHEST_RADII * self.radius_px:
                continue
            covered = np.empty((LAYERS, *window.pixels.shape[1:]))
            pose[:2] = fit[:2]
            cover(pose, self.table, covered)
            add_light(window.pixels[RESIDUAL].copy(), covered[0].copy(), pose, sums)
        self._teach(sums)

    def learn_light_at(
        self, windows: Sequence[Window], motion: Motion, row_time_s: float = 0.0
    ) -> None:
        """Learn the ball's light where it is said to be, not where a fit without it has it.

        A ball that is lit from one side fades into the ground: a smooth shading alone moves it
        towards the light, and a light that is learned there keeps it there.
        """
        sums = np.zeros((2, MAP_SIDE, MAP_SIDE))
        for window, pose in self._poses(_teaching(windows), motion, row_time_s):
            covered = np.empty((LAYERS, *window.pixels.shape[1:]))
            cover(pose, self.table, covered)
            left = _without_shading(window, covered)
            if left is not None:
                add_light(left, covered[0].copy(), pose, sums)
        self._teach(sums)

    def _teach(self, sums: Floats) -> None:
        known = sums[1] > LEAST_CELL
        self.table = self.table + np.where(known, sums[0] / np.maximum(sums[1], LEAST_CELL), 0.0)

    def _fits(
        self, windows: Sequence[Window], motion: Motion, row_time_s: float
    ) -> list[tuple[Window, Floats, Floats]]:
        """Fit the ball in each window; return window, fit and the pose that the fit began with.

        A fit is what `fit_place` returns, and what is left in the whole window.
        """
        posed = self._poses(windows, motion, row_time_s)
        fits = threads.each(self._fit, posed)
        return [(window, fit, pose) for (window, pose), fit in zip(posed, fits, strict=True)]

    def _fit(self, posed: tuple[Window, Floats]) -> Floats:
        window, pose = posed
        if self.patched:
            return fit_outline(window.pixels, pose, self.chance)
        fit = fit_place(window.pixels, pose, self.table)
        return np.append(fit, _left(window))

    def _poses(
        self, windows: Sequence[Window], motion: Motion, row_time_s: float
    ) -> list[tuple[Window, Floats]]:
        """Return each window with the pose of the ball that moves so."""
        index = {int(frame): k for k, frame in enumerate(motion.frames)}
        found = []
        for window in windows:
            k = index[window.frame]
            later = float(np.clip(row_time_s * motion.speeds[k, 0], -0.5, 0.5))
            grown = 1.0 if motion.larger is None else 1.0 + float(motion.larger[k])
            shape = [grown * self.radius_px / window.factor, self.blur_px, 1.0 / (1.0 - later)]
            way = self.exposure_s / window.factor * motion.speeds[k]
            found.append((window, np.array([*window.inward(motion.places[k]), *shape, *way])))
        return found


def _teaching(windows: Sequence[Window]) -> Sequence[Window]:
    """Return the windows of some frames, which teach the ball's light."""
    return windows[:: max(1, len(windows) // TEACHING_FRAMES)]


def _without_shading(window: Window, covered: Floats) -> Floats | None:
    """Return what the ground, the learned light and the best smooth shading leave of a window.

    Shape (rows, columns); None where the ball covers too little of it.
    """
    share, learned = covered[0], covered[LIGHT]
    light, ground, weights = window.pixels[0], window.pixels[GROUND], window.pixels[WEIGHT]
    left = light - ground * (1.0 - share) - learned
    own = (share > LEAST_COVER) & (weights > 0.0)
    if own.sum() < 3 * TERMS:
        return None
    root = np.sqrt(weights[own])
    terms = covered[:TERMS]
    best = np.linalg.lstsq((terms[:, own] * root).T, left[own] * root, rcond=None)[0]
    return np.asarray(left - np.tensordot(best, terms, axes=1))


def _left(window: Window) -> float:
    """Return the sum of squares that the last fit leaves in a window."""
    return float((window.pixels[WEIGHT] * window.pixels[RESIDUAL] ** 2).sum())
