"""Tabulated contacts of a campaign: what is known of each is its state before and after contact."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.operator import Body, States
from analysis.model.data.parts import Kept, cut, in_memory
from analysis.model.data.poses import PoseData
from analysis.model.fitting.systematics import Systematic
from analysis.model.predict.state import KICK_NUMBERS

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class ContactTable:
    """L numbers of each of S contacts, linear in the velocities and spins of both bodies.

    Attributes
    ----------
    shots
        Numbers of the shots, shape (S,).
    normal
        Unit vectors from a to b, taken as exact, shape (S, 3).
    start
        Velocities and spins before contact, as tabulated: where a fit starts.
    numbers, sigma
        What is tabulated and its standard errors, m/s and rad/s, shape (S, L). An infinite sigma:
        not measured.
    functional
        What each number is of the 48 numbers of the two flights (`sides`), shape (L, 48); 0 for
        durations.
    after
        Which numbers tell of the state after contact, shape (L,).
    open
        Which of a shot's own 24 numbers the table leaves to be fitted, shape (24,).
    bodies
        Sphere a, and sphere or plate b.
    gravity
        m/s^2 along +X.
    covariates
        What else is known of each shot, by name, each of shape (S,).
    scalars
        Whether only the scalars of thesis, section 7.1, are given: then n and t stand for the
        directions of every contact, and nothing is known across them.
    estimated
        Whether no errors are stated, and sigma is a scale for each channel, from the scatter.
    lasts
        Whether the last of the numbers is how long the contact lasts, s.
    excluded
        Numbers of shots that are not here because a person left them out.
    unused
        Columns of the shot list that are no covariates, with the reason.
    """

    shots: NDArray[np.intp]
    normal: Floats
    start: States
    numbers: Floats
    sigma: Floats
    functional: Floats
    after: NDArray[np.bool_]
    open: NDArray[np.bool_]
    bodies: tuple[Body, Body]
    gravity: float
    covariates: Mapping[str, Floats]
    scalars: bool
    estimated: bool = False
    lasts: bool = False
    excluded: tuple[int, ...] = ()
    unused: Mapping[str, str] = field(default_factory=dict)

    @property
    def jitter_s(self) -> float:
        """Return 0: there are no frames whose times could be uncertain."""
        return 0.0

    @property
    def systematics(self) -> tuple[Systematic, ...]:
        """Return none: a table knows nothing of images."""
        return ()

    @property
    def unusable(self) -> tuple[int, ...]:
        """Return no shot: every row of a table is used."""
        return ()

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Return which numbers are measured, shape (S, L)."""
        return np.isfinite(self.sigma)

    @property
    def weights(self) -> Floats:
        """Return 1 / sigma, zero where nothing was measured, shape (S, L)."""
        return np.where(self.measured, 1.0 / self.sigma, 0.0)

    @property
    def spins_unknown(self) -> NDArray[np.bool_]:
        """Return which bodies have a spin before contact that is not tabulated, shape (S, 2)."""
        if self.scalars:
            return np.zeros((len(self.shots), 2), dtype=np.bool_)
        spins = self.sigma[:, 6:12].reshape(-1, 2, 3)
        moves = np.array([not body.is_plate for body in self.bodies])
        return np.asarray(np.isinf(spins).any(axis=2) & moves)

    @property
    def nuisance_count(self) -> NDArray[np.intp]:
        """Return how many of each shot's own numbers are determined, shape (S,).

        Each that is tabulated of the state before contact determines one; where a spin is not, two
        more are those of a kick.
        """
        kicked = KICK_NUMBERS * self.spins_unknown.any(axis=1)
        return np.asarray(self.measured[:, ~self.after].sum(axis=1) + kicked)

    def before(self) -> ContactTable:
        """Return the table with all that tells of the state after contact taken out."""
        return replace(self, sigma=np.where(self.after, np.inf, self.sigma))

    def held_down(self, weight: Floats) -> ContactTable:
        """Return the table with the sigmas of each shot divided by a weight, shape (S,)."""
        return replace(self, sigma=self.sigma / weight[:, None])

    @property
    def channels(self) -> NDArray[np.bool_]:
        """Return which numbers are measured alike, shape (2, L).

        Velocities and spins; of scalars what is along the normal and what is across.
        """
        place = np.arange(len(self.after))
        first = place % 2 == 0 if self.scalars else place % 12 < 6
        return np.stack([first, ~first])

    @property
    def durations_s(self) -> Floats:
        """Return how long contacts last as measured, s, shape (S,); not a number where not."""
        measured = self.measured[:, -1] & self.lasts
        return np.where(measured, self.numbers[:, -1], np.nan)

    def without_durations(self) -> ContactTable:
        """Return the table of velocities and spins alone."""
        if not self.lasts:
            return self
        return replace(
            self,
            numbers=self.numbers[:, :-1],
            sigma=self.sigma[:, :-1],
            functional=self.functional[:-1],
            after=self.after[:-1],
            lasts=False,
        )

    def scaled(self, factor: Floats) -> ContactTable:
        """Return the table with the sigmas of each number multiplied, factors of shape (L,)."""
        return replace(self, sigma=self.sigma * factor)

    def of_shots(self, chosen: NDArray[np.bool_]) -> ContactTable:
        """Return some shots, mask of shape (S,)."""
        return self._taken(chosen)

    def parts(self) -> Iterator[ContactTable]:
        """Yield the table so many shots at a time."""
        return cut(self)

    def keep(self, kind: type[T]) -> Kept[T]:
        """Return where to keep what has a number for each shot: in memory."""
        return in_memory(kind)

    @property
    def count(self) -> int:
        """Number of shots."""
        return len(self.shots)

    def part(self, some: slice) -> ContactTable:
        """Return successive shots, without copying."""
        return self._taken(some)

    def _taken(self, some: NDArray[np.bool_] | slice) -> ContactTable:
        start = self.start
        parts = (start.velocity_a, start.velocity_b, start.spin_a, start.spin_b)
        return replace(
            self,
            shots=self.shots[some],
            normal=self.normal[some],
            start=States(*(part[some] for part in parts)),
            numbers=self.numbers[some],
            sigma=self.sigma[some],
            covariates={name: values[some] for name, values in self.covariates.items()},
        )


Data = PoseData | ContactTable
"""What a theory is held against: poses in every frame, or tabulated contacts."""
