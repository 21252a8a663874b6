"""The surroundings of a known ball in each frame: light of its channel, ground and weights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.balls.films.film import Film, FilmHead, Picture
from analysis.balls.films.tone import light
from analysis.balls.seen.background import background_without
from analysis.balls.seen.looks import CODED_RADIUS_PX, Looks
from analysis.balls.seen.photometry import WEIGHT
from analysis.balls.seen.surroundings import Box, Surroundings

Ints = NDArray[np.intp]
Singles = NDArray[np.float32]

MARGIN_RADII = 0.35
MARGIN_PX = 6.0
MOST_GROUNDS = 30
"""Half of the frames, at most, that tell what stands still."""
SATURATED = 0.998
"""Of the largest value of the file's kind."""

_Cuts = tuple[dict[int, Picture], dict[int, Picture]]
"""The ball's surroundings in each frame, and in some frames the part where it is in any."""


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """A ball's surroundings in one frame: light of the ball's channel, ground and weights.

    Attributes
    ----------
    frame
        Its number.
    top, left
        Of its first pixel.
    pixels
        Light, ground, weight, and what a fit leaves of the light; shape (4, rows, columns).
    factor
        Rows and columns of the picture in one of the window's.
    """

    frame: int
    top: int
    left: int
    pixels: Floats
    factor: int = 1

    def inward(self, place: Floats) -> Floats:
        """Return row and column of a place of the picture here."""
        return np.asarray((place - (self.top, self.left) + 0.5) / self.factor - 0.5)

    def outward(self, place: Floats) -> Floats:
        """Return row and column in the picture of a place here."""
        return np.asarray((place + 0.5) * self.factor - 0.5 + (self.top, self.left))


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Where a ball is expected, how fast it moves, and how large it is seen there.

    Attributes
    ----------
    frames, places, speeds
        Shapes (N,), (N, 2), (N, 2): px and px/s, in (row, column).
    larger
        By how much it is seen larger than its radius, relative, shape (N,); None: not known.
    """

    frames: Ints
    places: Floats
    speeds: Floats
    larger: Floats | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What the search has seen of a film.

    Attributes
    ----------
    gains
        Light of each frame over that of what stands still, shape (frames,); None: all alike.
    about
        What it has kept of the pictures; None: nothing.
    beside
        Frame, row and column of the ball outside its flights, shape (N, 3): held, at rest, or in
        bounces too low to count, it hides the ground too. None: nowhere.
    """

    gains: Floats | None = None
    about: Surroundings | None = None
    beside: Floats | None = None


NOTHING = Seen()


def cut_windows(
    film: Film, looks: Looks, motion: Motion, exposure_s: float, known: Seen = NOTHING
) -> list[Window]:
    """Return the surroundings of the ball in each frame, all as bright as one another.

    The film is read once more, but where the search has kept all that is needed. What stands still
    is learned again from frames in which the ball is elsewhere.
    """
    boxes = {
        int(frame): _box(film.head, looks, motion, k, exposure_s)
        for k, frame in enumerate(motion.frames)
    }
    top, left = (min(box[side] for box in boxes.values()) for side in (0, 1))
    bottom, right = (max(box[side] for box in boxes.values()) for side in (2, 3))
    whole = top, left, bottom, right
    cuts, samples = _kept(boxes, whole, known.about) or _read(film, boxes, whole)

    def shown(number: int, picture: Picture) -> Singles:
        gain = 1.0 if known.gains is None else float(known.gains[number])
        return np.asarray(_channel(picture, looks, film.head) / gain, dtype=np.float32)

    resting = {} if known.beside is None else _resting(film.head, looks, known.beside)
    hidden = [_hidden(whole, boxes.get(number, resting.get(number))) for number in samples]
    still = background_without([shown(*each) for each in samples.items()], hidden)
    # A codec keeps nothing of a rim that is finer than a few pixels; patches of many take long.
    coarse = film.head.compressed or looks.patched
    factor = max(1, int(looks.radius_px / CODED_RADIUS_PX)) if coarse else 1
    windows = []
    for number, cut in cuts.items():
        a, b, c, d = boxes[number]
        behind = still[a - top : c - top, b - left : d - left]
        windows.append(_window(number, (a, b), cut, (shown(number, cut), behind), factor))
    return windows


def _kept(boxes: dict[int, Box], whole: Box, about: Surroundings | None) -> _Cuts | None:
    """Return each frame's box, and samples of all boxes together; None where some were not kept."""
    if about is None:
        return None
    cuts: dict[int, Picture] = {}
    for number, box in boxes.items():
        cut = about.cut(number, box)
        if cut is None:
            return None
        cuts[number] = cut
    return cuts, {number: _of(picture, whole) for number, picture in about.samples.items()}


def _read(film: Film, boxes: dict[int, Box], whole: Box) -> _Cuts:
    cuts: dict[int, Picture] = {}
    samples: dict[int, Picture] = {}
    every = max(1, film.head.frames // MOST_GROUNDS)
    for number, picture in enumerate(film.pictures()):
        if number in boxes:
            cuts[number] = _of(picture, boxes[number]).copy()
        if number % every == 0:
            samples[number] = _of(picture, whole).copy()
    return cuts, samples


def _of(picture: Picture, box: Box) -> Picture:
    return picture[box[0] : box[2], box[1] : box[3]]


def _hidden(whole: Box, box: Box | None) -> NDArray[np.bool_]:
    """Return where the ball's own box lies in the box of all."""
    top, left, bottom, right = whole
    mask = np.zeros((bottom - top, right - left), dtype=bool)
    if box is not None:
        first, second, end, last = (
            max(0, edge - start) for edge, start in zip(box, (top, left, top, left), strict=True)
        )
        mask[first:end, second:last] = True
    return mask


def _resting(head: FilmHead, looks: Looks, beside: Floats) -> dict[int, Box]:
    """Return the boxes of a ball that is seen outside its flights, by frame."""
    still = Motion(beside[:, 0].astype(np.intp), beside[:, 1:], np.zeros((len(beside), 2)))
    return {int(frame): _box(head, looks, still, k, 0.0) for k, frame in enumerate(still.frames)}


def _box(head: FilmHead, looks: Looks, motion: Motion, k: int, exposure_s: float) -> Box:
    reach = looks.radius_px * (1 + MARGIN_RADII) + MARGIN_PX
    reach_both = reach + 0.5 * exposure_s * np.abs(motion.speeds[k])
    low = np.floor(motion.places[k] - reach_both).astype(int)
    high = np.ceil(motion.places[k] + reach_both).astype(int) + 1
    return (
        int(np.clip(low[0], 0, head.height - 1)),
        int(np.clip(low[1], 0, head.width - 1)),
        int(np.clip(high[0], 1, head.height)),
        int(np.clip(high[1], 1, head.width)),
    )


def _channel(picture: Picture, looks: Looks, head: FilmHead) -> Floats:
    return np.asarray(light(picture, head) @ looks.light_weights, dtype=np.float64)


def _window(
    frame: int,
    corner: tuple[int, int],
    cut: Picture,
    light_and_ground: tuple[Singles, Singles],
    factor: int,
) -> Window:
    most = SATURATED * np.iinfo(cut.dtype).max
    # Plane by plane: a processor takes many pixels at once.
    full = np.logical_or.reduce([plane >= most for plane in np.moveaxis(cut, 2, 0)])
    weight = (~full).astype(np.float64)
    layers = np.stack([*light_and_ground, weight, np.zeros(weight.shape)]).astype(np.float64)
    if factor > 1 and min(weight.shape) >= factor:
        layers = _binned(layers, factor)
        # One saturated pixel spoils all that it is counted with.
        layers[WEIGHT] = layers[WEIGHT] >= 1.0
        return Window(frame, *corner, layers, factor)
    return Window(frame, *corner, layers)


def _binned(layers: Floats, factor: int) -> Floats:
    """Return the means of blocks of pixels; what is left over at the end falls away."""
    count, rows, columns = layers.shape[0], layers.shape[1] // factor, layers.shape[2] // factor
    whole = layers[:, : rows * factor, : columns * factor]
    blocks = whole.reshape(count, rows, factor, columns, factor)
    return np.ascontiguousarray(blocks.mean(axis=(2, 4)))
