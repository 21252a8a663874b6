"""Which outline is which sphere in which view, through all frames of a shot.

Discs are recognised once, in the frame that shows them best, and followed from there both ways:
a sphere may rise into the rows of the other view, so rows alone do not tell.
"""

from __future__ import annotations

import numpy as np

from analysis.arrays import Floats, as_singles
from analysis.errors import ShotRefusedError
from analysis.imaging.discs import Disc, discs, pair_apart, vote, vote_radii
from analysis.imaging.edge.frame import FilmEdges, filters
from analysis.imaging.film_discs import FilmDiscs, film_discs
from analysis.imaging.film_following import FilmCurves, Rules, follow_discs
from analysis.imaging.flight_hypotheses import Falling, guide, meeting, mirrored, within
from analysis.imaging.outlines import Place
from analysis.imaging.views import View, ViewGeometry

LEAST_RIM_SHARE = 0.2
CLEAR_RIM_SHARE = 0.4
"""Where every disc shows as much of its rim, and nothing else does, no better frame is sought."""
LEAST_COVERAGE = 0.4
LEAST_APART = 0.45
"""Of both radii together: two places nearer than that are one disc, voted for twice."""
KEEP_OFF_SIGMAS = 2.5
FEW_FRAMES = 6
"""With both spheres: no collision is measured in fewer."""
LARGE_STEP, LARGE_QUANTILE = 0.5, 0.75
"""Radii from frame to frame, in most frames, beyond which nearness may take one disc for another.
Where spheres turn back they are 1.7 steps from where their motion predicts them."""


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
    most_seen: tuple[list[int], int, list[Place]] = ([-1], 0, [])
    for k in _middle_first(len(film)):
        edges = film.whole(k)
        found = {
            radius: discs(vote(edges.points, radius, edges.shape), LEAST_RIM_SHARE, radius)
            for radius in dict.fromkeys(radii_px)
        }
        pairs: dict[View, tuple[Disc, Disc]] = {}
        seen: list[int] = []
        for geometry in views:
            a, b = ([d for d in found[radius] if _inside(d, geometry)] for radius in radii_px)
            pair = pair_apart(a, b, LEAST_APART * sum(radii_px))
            seen.append(2 if pair is not None else min(len(a) + len(b), 1))
            if pair is not None:
                alike = radii_px[0] == radii_px[1] and pair[0].column > pair[1].column
                pairs[geometry.view] = pair[::-1] if alike else pair
        if sum(seen) > sum(most_seen[0]):
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
        shown_of_two = " and ".join(
            f"{count} of 2 in the {own.view.value} view"
            for count, own in zip(seen, views, strict=True)
        )
        raise ShotRefusedError(
            "assignment",
            f"no frame shows both spheres{_each(views)}; the best frame shows {shown_of_two}, as "
            f"discs of radius {radii} px",
            k,
            shown,
        )
    return best[1], best[2]


def _each(views: tuple[ViewGeometry, ...]) -> str:
    if len(views) == 1:
        return ""
    return f" in each of {len(views)} views with the columns of the views in agreement"


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
    falling: Falling,
    *,
    least_coverage: float = LEAST_COVERAGE,
) -> tuple[FilmDiscs, FilmCurves]:
    """Follow both spheres in all views through all frames (`film_following.follow_discs`).

    From frame to frame by nearness; where that loses them, or where they move by half a radius and
    more, by free flights that meet (`flight_hypotheses`), if these show more of them.

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
    rules = (KEEP_OFF_SIGMAS * film.settings.sigma_px, False), least_coverage
    seed, pairs = seed_frame(film, views, radii_px)
    places = [
        [(pair[i].row, pair[i].column, radius) for pair in pairs.values()]
        for i, radius in enumerate(radii_px)
    ]
    discs = np.array(places).reshape(-1, 3)
    near = _followed(film, views, (seed, discs, np.empty((len(discs), 0, 2))), rules)
    alike = len(set(vote_radii(radii_px))) == 1
    first, second = (_first_column(near[0], i) for i in (0, 1))
    if alike and first > second:
        near = near[0].swapped(), near[1]
    if not _in_large_steps(near[0], min(radii_px)):
        return near
    whereabouts = _by_flights(film, views, radii_px, falling)
    if whereabouts is None:
        return near
    shown = np.isfinite(whereabouts[..., 0]).sum(axis=0)
    by_flights = _followed(film, views, (int(shown.argmax()), discs, whereabouts), rules)
    return by_flights if _both_shown(by_flights[0]) > _both_shown(near[0]) else near


def _followed(
    film: FilmEdges,
    views: tuple[ViewGeometry, ...],
    start: tuple[int, Floats, Floats],
    rules: Rules,
) -> tuple[FilmDiscs, FilmCurves]:
    frames = as_singles(film.frames)
    filtered = filters(film.settings, film.least_strength)
    curves, outlines = follow_discs(frames, filtered, start, rules)
    return film_discs(tuple(geometry.view for geometry in views), outlines), curves


def _in_large_steps(discs: FilmDiscs, radius_px: float) -> bool:
    """Tell whether nearness lost the discs at once, or they move by half a radius a frame."""
    if _both_shown(discs) < FEW_FRAMES:
        return True
    front = discs.views.index(View.FRONT)
    places, shown = discs.circles[:, front, :, :2], discs.found[:, front]
    steps = np.hypot(*np.moveaxis(np.diff(places, axis=1), -1, 0))[shown[:, 1:] & shown[:, :-1]]
    return bool(steps.size and np.quantile(steps, LARGE_QUANTILE) > LARGE_STEP * radius_px)


def _both_shown(discs: FilmDiscs) -> int:
    return int(discs.found[:, discs.views.index(View.FRONT)].all(axis=0).sum())


def _by_flights(
    film: FilmEdges,
    views: tuple[ViewGeometry, ...],
    radii_px: tuple[float, float],
    falling: Falling,
) -> Floats | None:
    """Return where the discs are by flights that meet, shape (discs, frames, 2); None without."""
    votes = vote_radii(radii_px)
    seen = {radius: [_peaks(film, k, radius) for k in range(len(film))] for radius in set(votes)}
    front = next(geometry for geometry in views if geometry.view is View.FRONT)
    four = meeting((seen[votes[0]], seen[votes[1]]), front.rows, radii_px, falling)
    if four is None:
        return None
    places = np.full((2, len(views), len(film), 2), np.nan)
    places[:, views.index(front)] = guide(four, falling)
    for v, view in enumerate(views):
        if view is front:
            continue
        shown = [[within(own, view.rows) for own in seen[radius]] for radius in votes]
        shift = view.origin[1] - front.origin[1]
        for i, flown in enumerate(mirrored(four, shown, votes, shift, falling)):
            for own in flown:
                places[i, v, own.frames] = own.places
    return places.reshape(-1, len(film), 2)


def _peaks(film: FilmEdges, k: int, radius: float) -> Floats:
    """Return rows and columns of all discs of a radius in a frame, shape (discs, 2)."""
    edges = film.whole(k)
    found = discs(vote(edges.points, radius, edges.shape), LEAST_RIM_SHARE, radius)
    return np.array([(disc.row, disc.column) for disc in found]).reshape(-1, 2)


def _first_column(discs: FilmDiscs, sphere: int) -> float:
    front = sphere, discs.views.index(View.FRONT)
    frames = np.flatnonzero(discs.found[front])
    return float(discs.circles[front][frames[0], 1]) if frames.size else np.inf
