"""The measured impacts of a campaign: four velocities a shot, with their covariance.

No law of contact enters. Regression as in the thesis, section 7.1, uses these impacts; the fit to
all poses is independent of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats
from analysis.collision.coefficients import HELD
from analysis.collision.operator import Body
from analysis.effects.contact.tangential_compliance import lever_of

V_N, V_S, V_N_AFTER, V_S_AFTER = range(4)
"""Where the velocities stand in a row."""
SHARED = HELD + 3
APPROACH_SIGMAS = 3.0
"""An approach that is not so many standard errors from zero is no measured impact."""


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A shot that the results do not use, and why, in one clause."""

    shot: int
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class Impacts:
    """S measured impacts.

    Attributes
    ----------
    shots
        Numbers of the shots, shape (S,).
    velocities
        v_n, v_s, v_n', v_s' of section 7.1, m/s, shape (S, 4): v_n negative, v_s a length. Not a
        number where spins, and with them v_s and v_s', were not measured.
    covariance
        Of these, (m/s)^2, shape (S, 4, 4).
    shared
        What one standard error of each thing that all shots share does to the velocities, m/s,
        shape (S, SHARED, 4), as `analysis.collision.coefficients` orders them; None: none is known.
    lever
        By how much friction changes the surface velocity more than the velocity along: 1 + 1/K of
        the thesis, 3.5 for solid spheres.
    left_out
        Shots that are not here.
    """

    shots: NDArray[np.intp]
    velocities: Floats
    covariance: Floats
    lever: float
    left_out: tuple[LeftOut, ...] = ()
    shared: Floats | None = None

    @property
    def surface(self) -> NDArray[np.bool_]:
        """Return in which shots v_s and v_s' are measured, shape (S,)."""
        return np.asarray(np.isfinite(self.velocities[:, [V_S, V_S_AFTER]]).all(axis=1))

    def of_shots(self, chosen: NDArray[np.bool_]) -> Impacts:
        """Return some impacts, mask of shape (S,)."""
        return replace(
            self,
            shots=self.shots[chosen],
            velocities=self.velocities[chosen],
            covariance=self.covariance[chosen],
            shared=None if self.shared is None else self.shared[chosen],
        )

    @property
    def common(self) -> Floats | None:
        """Return the part of the covariance that all shots share, (m/s)^2, shape (S, 4, 4)."""
        if self.shared is None:
            return None
        held = self.shared[:, :HELD]
        return np.asarray(np.swapaxes(held, 1, 2) @ held)

    def apart(self) -> Impacts:
        """Return the same with a covariance of what each shot errs by itself."""
        common = self.common
        return self if common is None else replace(self, covariance=self.covariance - common)

    def moved(self, error: int) -> Impacts:
        """Return the same as one standard error of something shared would have it."""
        if self.shared is None:
            return self
        return replace(self, velocities=self.velocities + self.shared[:, error])

    def without_surface(self) -> Impacts:
        """Return the same with the normal velocities alone."""
        velocities = self.velocities.copy()
        velocities[:, [V_S, V_S_AFTER]] = np.nan
        return replace(self, velocities=velocities)

    @property
    def approach(self) -> Floats:
        """Return the approach speed -v_n, m/s, shape (S,)."""
        return np.asarray(-self.velocities[:, V_N])


def measured_impacts(
    shots: NDArray[np.intp],
    velocities: Floats,
    covariance: Floats,
    bodies: tuple[Body, Body],
    shared: Floats | None = None,
) -> Impacts:
    """Return the impacts whose normal velocities are measured; the others are listed as left out.

    Parameters
    ----------
    velocities, covariance, shared
        Shapes (S, 4), (S, 4, 4) and (S, K, 4); a row without a finite v_n has no impact.
    """
    touching = np.isfinite(velocities[:, V_N])
    sigma = np.sqrt(np.where(touching, covariance[:, V_N, V_N], 0.0))
    approaching = touching & (-velocities[:, V_N] > APPROACH_SIGMAS * sigma)
    parting = np.isfinite(velocities[:, V_N_AFTER])
    left_out = []
    for row in np.flatnonzero(~(approaching & parting)):
        if not touching[row]:
            reason = "on their paths before contact the spheres pass each other by"
        elif not approaching[row]:
            found = f"{-velocities[row, V_N]:.4f} ± {sigma[row]:.4f} m/s"
            reason = f"its approach, {found}, is not told from zero"
        else:
            reason = "the velocity after contact was not measured"
        left_out.append(LeftOut(int(shots[row]), reason))
    kept = approaching & parting
    return Impacts(
        shots=shots[kept],
        velocities=velocities[kept],
        covariance=covariance[kept],
        lever=lever_of(bodies),
        left_out=tuple(left_out),
        shared=None if shared is None else shared[kept],
    )
