"""A known pair through a shot: found once, then followed from frame to frame both ways."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.errors import ShotRefusedError
from analysis.imaging.discs import Disc, pair_apart, vote_radii
from analysis.imaging.flight_hypotheses import Falling
from analysis.imaging.views import View
from analysis.motion.turning import turn_between, turned
from analysis.photometric.follow.confirmation import confirmed
from analysis.photometric.follow.film import Film, cost_of, others_of
from analysis.photometric.follow.orientation_search import Found, search_orientation, turns
from analysis.photometric.follow.visibility import drop_unseen, seen_as_own
from analysis.photometric.follow.votes import peak_near, peaks, vote_map, whereabouts_by_flights
from analysis.photometric.learn.appearance import Appearance
from analysis.photometric.render.camera import disc_of
from analysis.photometric.render.pose import fit_frames
from analysis.photometric.render.sight import Reel, Scene, Sight, Stance

Single = NDArray[np.float32]

NEAR_LIMITS = np.array([6.0])
FOLLOW_LIMITS = np.array([15.0, 6.0])
WIDE_LIMITS = np.array([40.0, 15.0, 6.0, 6.0])
"""From a prediction by two frames in free flight, from one that a contact spoilt, and from a lesser
one."""
NEAR = 0.004
"""Step, in radii and radians, that shows a prediction to have been near: five errors of one."""
REACH_PX = 6.0
MOST_COST = 6.0
"""1 to 2 for a sound frame (`film.cost_of`), 2 to 4 where the spheres turn a side with unknown
markers to the camera."""
GROWS, LOST = 1.1, 1.25
"""Growth of that cost from frame to frame: the most that is sound, and what calls for a search."""
SAME_COLUMN_PX = 2.0
LEAST_APART = 2.3
"""Radii between the centres in the frame where the pair is looked for."""
LEAST_INSIDE = 0.5
"""Radii from the frame's edge to the centres there: a sphere that enters with half of itself would
be lost again before its motion is known."""
TRIED_FRAMES = 4
LOOKED_AT = 4
"""Frames that are looked at before all are."""
CLEAR_VOTES = 0.5
"""Of those that a whole outline gives: a sphere that is half hidden has fewer."""


class Follower:
    """Follows a known pair through the frames of one shot.

    Parameters
    ----------
    film
        Without poses; its background is a first guess.
    known
        The pair and its camera.
    """

    def __init__(self, film: Film, known: Appearance) -> None:
        self._film, self._known = film, known
        self._looks = known.looks()
        self._optics = known.camera.optics
        a, b = (float(self._optics.scales[0] * sphere.radius_m) for sphere in known.spheres)
        self._radii = vote_radii((a, b))
        self._candidates = turns()
        self._reels = film.reel(known, 0), film.reel(known, 1)
        self._votes: dict[int, tuple[Single, Single]] = {}
        self._flights: Floats | None = None

    def run(self, times_s: Floats) -> None:
        """Fill the film's poses.

        Raises
        ------
        ShotRefusedError
            No frame shows the pair as it is known.
        """
        first = self._find_start()
        self._film.placed[:] = False
        self._film.placed[:, first] = True
        for step in (1, -1):
            self._follow(first, step, times_s)
        radii = np.array([sphere.radius_m for sphere in self._known.spheres])
        drop_unseen(self._film, self._optics, radii)

    def _vote(self, frame: int) -> tuple[Single, Single]:
        """Return the votes for discs of the size of a and of b."""
        if frame not in self._votes:
            film = self._film
            votes = {
                radius: vote_map(film.frames[frame], film.background, film.noise, radius)
                for radius in dict.fromkeys(self._radii)
            }
            self._votes[frame] = votes[self._radii[0]], votes[self._radii[1]]
        return self._votes[frame]

    def _find_start(self) -> int:
        """Find a frame in which both spheres stand apart and look as they are known to."""
        count, costs, doubtful = len(self._film.frames), list[float](), list[int]()
        few = list(range(0, count, max(1, count // LOOKED_AT)))
        for frames in (few, [k for k in range(count) if k not in few]):
            for k, centres in islice(self._apart(frames), TRIED_FRAMES):
                cost, certain = self._cost_at(k, centres)
                costs.append(cost)
                if cost < MOST_COST and certain:
                    return k
                if cost < MOST_COST:
                    doubtful.append(k)
        if doubtful:
            # Spheres with few markers: nothing in the film may tell two of them apart.
            return doubtful[0]
        what = f"chi-squared {min(costs):.1f} a pixel" if costs else "no two discs of their size"
        raise ShotRefusedError(
            "assignment", f"no frame shows the spheres as they were learned ({what})"
        )

    def _apart(self, frames: Iterable[int]) -> Iterator[tuple[int, Floats]]:
        """Yield frames in which both spheres stand apart, with their centres.

        One that shows them clearly at once, before others are looked at; then by their votes.
        """
        others: list[tuple[float, int, Floats]] = []
        for k in frames:
            centres, votes = self._pair(k) or (None, 0.0)
            if centres is not None and votes > CLEAR_VOTES:
                yield k, centres
            elif centres is not None:
                others.append((votes, k, centres))
        for _, k, centres in sorted(others, key=lambda item: -item[0]):
            yield k, centres

    def _cost_at(self, k: int, centres: Floats) -> tuple[float, bool]:
        """Place both spheres in a frame; return their cost, and whether no other turns fit as well.

        Infinite cost, and no pose, where they are not there.
        """
        film = self._film
        film.centre[:, k], film.placed[:, k] = centres, True
        found = [self._search(i, k) for i in (0, 1)]
        cost = max(one.cost for one in found)
        there = all(self._confirmed(i, k) for i in (0, 1))
        film.placed[:, k] = cost < MOST_COST and there
        return cost if there else np.inf, all(one.certain for one in found)

    def _pair(self, k: int) -> tuple[Floats, float] | None:
        """Return the centres of spheres a and b, m, shape (2, 3), and the lesser one's votes.

        None unless both stand apart.
        """
        votes = self._vote(k)
        split = self._front_from()
        apart = LEAST_APART * sum(self._radii) / 2
        a, b = ([Disc(*place) for place in peaks(map_[split:], 2, apart)] for map_ in votes)
        front = pair_apart(a, b, apart)
        if front is None:
            return None
        if self._radii[0] == self._radii[1] and front[0].column > front[1].column:
            front = front[::-1]
        centres = np.zeros((2, 3))
        for i, (centre, disc) in enumerate(zip(centres, front, strict=True)):
            if not self._well_inside(i, disc):
                return None
            place = disc.row + split, disc.column
            centre[:2] = self._known.camera.at_pixels(0, place, 0.0)
            if len(self._optics.scales) > 1:
                above = self._above(i, votes[i], disc.column)
                if above is None:
                    return None
                centre[2] = above
        return centres, min(disc.rim_share for disc in front)

    def _well_inside(self, i: int, disc: Disc) -> bool:
        """Return whether sphere i, at a disc below the top view, stays in the frame for long."""
        rows, columns = self._film.frames.shape[1:]
        least = LEAST_INSIDE * self._radii[i]
        last = rows - 1 - self._front_from() - least
        return bool(disc.row <= last and least <= disc.column <= columns - 1 - least)

    def _front_from(self) -> int:
        """Return the first row that can hold a centre of the front view."""
        if View.TOP not in self._known.camera.views:
            return 0
        return int(self._optics.rows[1, 1])

    def _above(self, i: int, votes: Single, column: float) -> float | None:
        """Return Z of sphere i by its disc in the top view at a column of the front view."""
        y = float(self._known.camera.at_pixels(0, (0.0, column), 0.0)[1])
        _, expected, _ = disc_of(self._optics, 1, np.array([0.0, y, 0.0]), 0.0)
        low = max(int(expected) - 3, 0)
        strip = votes[: self._front_from(), low : int(expected) + 5]
        best = peaks(strip, 1, self._radii[i]) if strip.size else []
        if not best:
            return None
        return float(-self._known.camera.at_pixels(1, best[0][:2], 0.0)[0])

    def _reel(self, i: int, k: int) -> Reel:
        """Return the film as sphere i is seen in it, the other sphere where it is in frame k."""
        discs = self._film.discs(self._known, slice(k, k + 1))[0]
        self._reels[i].others[k] = others_of(discs, i)
        return self._reels[i]

    def _stance(self, i: int, k: int) -> Stance:
        film = self._film
        return Stance(film.centre[i, k], film.rotation[i, k], film.lights[i, k])

    def _confirmed(self, i: int, k: int) -> bool:
        return bool(confirmed(self._reel(i, k), np.array([k]))[0])

    def _search(self, i: int, k: int) -> Found:
        film, reel, stance = self._film, self._reel(i, k), self._stance(i, k)
        scene = Scene(film.frames[k], film.background, film.noise, film.shadowed[k])
        sight = Sight(scene, self._optics, self._looks[i], reel.others[k], film.motion[i, k])
        found = search_orientation(sight, stance, self._candidates)
        for part, best in zip(stance, found.stance, strict=True):
            part[:] = best
        return found

    def _follow(self, first: int, step: int, times_s: Floats) -> None:
        """Follow both spheres to one end of the shot.

        One that leaves the frame, or rises into what the mirror shows, is let go.
        """
        film = self._film
        usual = [self._fit(i, first, FOLLOW_LIMITS) for i in (0, 1)]
        k = first + step
        while 0 <= k < len(film.frames):
            here = [i for i in (0, 1) if film.placed[i, k - step]]
            for i in here:
                self._predict(i, k, step, times_s)
                film.placed[i, k] = True
            seen = [seen_as_own(film, self._known, i, k) for i in here]
            film.placed[here, k] = seen
            here = [i for i in here if film.placed[i, k]]
            for i in here:
                cost = self._settle(i, k, step, times_s, LOST * usual[i])
                if k == first + step and cost > LOST * usual[i] and self._found_by_flights():
                    self._predict(i, k, step, times_s)
                    cost = self._settle(i, k, step, times_s, LOST * usual[i])
                usual[i] = min(max(cost, 1.0), GROWS * usual[i])
            k += step

    def _settle(self, i: int, k: int, step: int, times_s: Floats, most: float) -> float:
        """Fit a predicted pose, with ever wider searches while it costs more than `most`.

        Beside a contact the prediction is wrong by pixels: then the discs themselves say where
        they are, and at last all orientations are tried. The best of these stays.
        """
        cost = self._fit(i, k, NEAR_LIMITS)
        if cost > most or (self._film.quality[i, k, 3:] > NEAR).any():
            self._predict(i, k, step, times_s)
            if not self._has_velocity(i, k, step):
                self._attract(i, k)
            cost = self._fit(i, k, FOLLOW_LIMITS)
        for widen in (False, True):
            if cost <= most and self._confirmed(i, k):
                break
            kept = Stance(*(part.copy() for part in self._stance(i, k)))
            self._predict(i, k, step, times_s)
            self._attract(i, k)
            again = self._search(i, k).cost if widen else self._fit(i, k, WIDE_LIMITS)
            if again < cost:
                cost = again
            else:
                for part, old in zip(self._stance(i, k), kept, strict=True):
                    part[:] = old
        return cost

    def _found_by_flights(self) -> bool:
        """Look for the spheres by free flights that meet, in all frames at once; tell whether any.

        For spheres that move by so much from frame to frame that nothing is near (`_attract`).
        """
        if self._flights is None:
            film = self._film
            every = [self._vote(k) for k in range(len(film.frames))]
            falling = Falling(film.times_s, float(self._optics.scales[0]) * film.gravity)
            self._flights = whereabouts_by_flights(
                ([a for a, _ in every], [b for _, b in every]),
                self._radii,
                self._known.camera,
                falling,
            )
        return self._flights is not None

    def _fit(self, i: int, k: int, limits: Floats) -> float:
        """Fit a pose; return its `film.cost`."""
        fit_frames(self._reel(i, k), np.array([k]), limits)
        return float(cost_of(self._film.quality[i, k], limits[-1]))

    def _predict(self, i: int, k: int, step: int, times_s: Floats) -> None:
        """Carry the pose on from the two frames before, or the one there is."""
        film, last, before = self._film, k - step, k - 2 * step
        film.lights[i, k] = film.lights[i, last]
        film.centre[i, k], film.rotation[i, k] = film.centre[i, last], film.rotation[i, last]
        if self._has_velocity(i, k, step):
            share = (times_s[k] - times_s[last]) / (times_s[last] - times_s[before])
            film.centre[i, k] += share * (film.centre[i, last] - film.centre[i, before])
            turn = turn_between(film.rotation[i, before], film.rotation[i, last])
            film.rotation[i, k] = turned(share * turn, film.rotation[i, last])
        if self._flights is not None:
            known = np.isfinite(self._flights[i, k])
            film.centre[i, k, known] = self._flights[i, k, known]

    def _has_velocity(self, i: int, k: int, step: int) -> bool:
        before = k - 2 * step
        return 0 <= before < len(self._film.frames) and bool(self._film.placed[i, before])

    def _attract(self, i: int, k: int) -> None:
        """Draw a predicted centre to the discs that the frame shows near it.

        One that flights predict is at its disc.
        """
        if self._flights is not None and np.isfinite(self._flights[i, k, 0]):
            return
        film, optics = self._film, self._optics
        votes = self._vote(k)[i]
        row, column, _ = disc_of(optics, 0, film.centre[i, k], self._looks[i].radius_m)
        there = peak_near(votes, (row, column), REACH_PX)
        film.centre[i, k, 0] += (there[0] - row) / optics.scales[0]
        film.centre[i, k, 1] += (there[1] - column) / optics.scales[0]
        if len(optics.scales) > 1:
            row, column, _ = disc_of(optics, 1, film.centre[i, k], self._looks[i].radius_m)
            there = peak_near(votes, (row, column), REACH_PX)
            if abs(there[1] - column) < SAME_COLUMN_PX and self._alone_above(i, k):
                film.centre[i, k, 2] -= (there[0] - row) / optics.scales[1]

    def _alone_above(self, i: int, k: int) -> bool:
        """Tell whether the top view shows a sphere's disc well away from the other one's."""
        if not self._film.placed[1 - i, k]:
            return True
        apart = (self._film.centre[0, k] - self._film.centre[1, k]) * self._optics.scales[1]
        return float(np.hypot(apart[1], apart[2])) > 2 * REACH_PX
