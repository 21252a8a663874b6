"""A first look at a film: where its ball is in some frames, for a person to see and to mend."""

from __future__ import annotations

from collections.abc import Mapping

from analysis.balls.discs.finding import Disc
from analysis.balls.films.film import Picture
from analysis.balls.searching import radii_px
from analysis.balls.seen.background import background
from analysis.balls.seen.looks import families, find_discs_that_move, noise_of


def rings(pictures: Mapping[int, Picture]) -> dict[int, Disc]:
    """Return the surest disc of the size that is seen most surely, by frame.

    Parameters
    ----------
    pictures
        Some frames of a film, shape (rows, columns, channels), with their numbers. What differs
        from what most of them show is looked at; a frame without such a disc is left out.
    """
    samples = dict(pictures)
    ground = background(list(samples.values()))
    noise = noise_of(list(samples.values()), ground)
    sizes = families(find_discs_that_move(samples, ground, noise, radii_px(ground)))
    if not sizes:
        return {}
    # Of each frame the surest disc comes first.
    return dict(reversed(sizes[0]))
