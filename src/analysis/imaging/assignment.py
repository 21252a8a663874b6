"""Which outline is which sphere in which view, through all frames of a shot.

Discs are recognised once, in the frame that shows them best, and followed from there both ways:
a sphere may rise into the rows of the other view, so rows alone do not tell.
"""

from __future__ import annotations

import numpy as np

from analysis.errors import ShotRefusedError
from analysis.imaging.discs import Disc, discs, pair_apart, vote, vote_radii
from analysis.imaging.edge.frame import FilmEdges, filters
from analysis.imaging.film_discs import FilmDiscs, film_discs
from analysis.imaging.film_following import FilmCurves, follow_discs
from analysis.imaging.outlines import Place
from analysis.imaging.views import View, ViewGeometry

LEAST_RIM_SHARE = 0.2
CLEAR_RIM_SHARE = 0.4
"""Where every disc shows as much of its rim, and nothing else does, no better frame is sought."""
LEAST_COVERAGE = 0.4
LEAST_APART = 0.45
"""Of both radii together: two places nearer than that are one disc, voted for twice."""
KEEP_OFF_SIGMAS = 2.5


def seed_frame(
    film: FilmEdges, views: tuple[ViewGeometry, ...], radii_px: tuple[float, float]
) -> tuple[int, dict[View, tuple[Disc, Disc]]]:
    """Find a frame that shows both spheres clearly in every view, or else the one that does best.

    Parameters
    ----------
    radii_px
        Of spheres a and b.

    Returns
    -------
    The frame's index, and for each view the discs of a and b; of spheres alike the left one first.

    Raises
    ------
    ShotRefusedError
        No frame shows two spheres in each view.
    """
    radii_px = vote_radii(radii_px)
    best: tuple[float, int, dict[View, tuple[Disc, Disc]]] | None = None
    most_seen: tuple[int, int, list[Place]] = (-1, 0, [])
    for k in _middle_first(len(film)):
        edges = film.whole(k)
        found = {
            radius: discs(vote(edges.points, radius, edges.shape), LEAST_RIM_SHARE, radius)
            for radius in dict.fromkeys(radii_px)
        }
        pairs: dict[View, tuple[Disc, Disc]] = {}
        seen = 0
        for geometry in views:
            a, b = ([d for d in found[radius] if _inside(d, geometry)] for radius in radii_px)
            pair = pair_apart(a, b, LEAST_APART * sum(radii_px))
            seen += 2 if pair is not None else min(len(a) + len(b), 1)
            if pair is not None:
                alike = radii_px[0] == radii_px[1] and pair[0].column > pair[1].column
                pairs[geometry.view] = pair[::-1] if alike else pair
        if seen > most_seen[0]:
            shown = [(d.row, d.column, r) for r, every in found.items() for d in every]
            most_seen = (seen, k, shown)
        if len(pairs) < len(views) or not _columns_agree(pairs, max(radii_px)):
            continue
        shares = [d.rim_share for pair in pairs.values() for d in pair]
        if best is None or sum(shares) > best[0]:
            best = (sum(shares), k, pairs)
        alone = sum(map(len, found.values())) == len(shares)
        if alone and min(shares) >= CLEAR_RIM_SHARE:
            break
    if best is None:
        seen, k, shown = most_seen
        radii = " and ".join(f"{radius:.1f}" for radius in dict.fromkeys(radii_px))
        places = ", ".join(f"({row:.0f}, {column:.0f})" for row, column, _ in shown)
        raise ShotRefusedError(
            "assignment",
            f"no frame shows two spheres in each of {len(views)} views with the columns of the "
            f"views in agreement; the best frame shows {seen} of {2 * len(views)} discs of "
            f"radius {radii} px, at (row, column) {places or 'none'}",
            k,
            shown,
        )
    return best[1], best[2]


def _inside(disc: Disc, geometry: ViewGeometry) -> bool:
    return geometry.rows[0] <= disc.row < geometry.rows[1]


def _middle_first(count: int) -> list[int]:
    """Return all indices below a number, the middle, the quarters, the eighths, and so on."""
    order: list[int] = []
    step = 1 << count.bit_length()
    while step > 1:
        order.extend(range(step // 2, count, step))
        step //= 2
    return [*order, *range(min(count, 1))]


def _columns_agree(pairs: dict[View, tuple[Disc, Disc]], radius_px: float) -> bool:
    columns = np.array([[disc.column for disc in pair] for pair in pairs.values()])
    return bool(np.ptp(columns, axis=0).max() < 0.5 * radius_px)


def follow(
    film: FilmEdges,
    views: tuple[ViewGeometry, ...],
    radii_px: tuple[float, float],
    *,
    least_coverage: float = LEAST_COVERAGE,
) -> tuple[FilmDiscs, FilmCurves]:
    """Follow both spheres in all views through all frames (`film_following.follow_discs`).

    Parameters
    ----------
    radii_px
        Of spheres a and b.
    least_coverage
        Share of its limb that an outline shows, to be believed.

    Returns
    -------
    The discs of sphere a (of spheres alike the one that comes from the left) and of sphere b; and
    the edges about them.

    Raises
    ------
    ShotRefusedError
        No frame shows two spheres in each view.
    """
    seed, pairs = seed_frame(film, views, radii_px)
    places = [
        [(pair[i].row, pair[i].column, radius) for pair in pairs.values()]
        for i, radius in enumerate(radii_px)
    ]
    start = seed, np.array(places).reshape(-1, 3)
    frames = np.require(film.frames, None, ["C", "W"])
    rules = (KEEP_OFF_SIGMAS * film.settings.sigma_px, False), least_coverage
    filtered = filters(film.settings, film.least_strength)
    curves, outlines = follow_discs(frames, filtered, start, rules)
    discs = film_discs(tuple(pairs), outlines)
    first, second = (_first_column(discs, i) for i in (0, 1))
    alike = len(set(vote_radii(radii_px))) == 1
    return (discs.swapped() if alike and first > second else discs), curves


def _first_column(discs: FilmDiscs, sphere: int) -> float:
    front = sphere, discs.views.index(View.FRONT)
    frames = np.flatnonzero(discs.found[front])
    return float(discs.circles[front][frames[0], 1]) if frames.size else np.inf
