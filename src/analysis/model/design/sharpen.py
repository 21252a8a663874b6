"""Shots that make a parameter surer, and how many of them it takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Floats
from analysis.launch.result import LaunchFit
from analysis.model.data.poses import PoseData
from analysis.model.design.between import MOST_EVEN, MOST_SHOTS, Repeated, repeated
from analysis.model.design.candidates import Setting, candidates, foreseen_shots
from analysis.model.design.choice import chosen, fewest_even
from analysis.model.design.divergence import by_shot
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.normal import with_prior


@dataclass(frozen=True, slots=True, eq=False)
class Sharpening:
    """Shots that sharpen a parameter.

    Attributes
    ----------
    parameter, unit
        What is to be surer.
    present, target, reached
        Its standard error by the campaign, as asked for, and with the shots.
    shots
        What to fire.
    even
        How many shots spread evenly over all settings do as much; None: more than 5000.
    """

    parameter: str
    unit: str
    present: float
    target: float
    reached: float
    shots: tuple[Repeated, ...]
    even: int | None

    @property
    def count(self) -> int:
        """Shots in all."""
        return sum(one.repeat for one in self.shots)

    @property
    def enough(self) -> bool:
        """Whether the target is reached."""
        return self.reached <= self.target


@dataclass(frozen=True, slots=True, eq=False)
class Sharpness:
    """Ds-criterion: the variance of one of P parameters, all others fitted beside it.

    `known` is the campaign's information, (P, P), `shown` that of a shot at each setting,
    (K, P, P).
    """

    known: Floats
    shown: Floats
    place: int

    @property
    def size(self) -> int:
        """Number of settings."""
        return len(self.shown)

    def sigma(self, counts: Floats) -> float:
        """Return the standard error for counts (K,)."""
        return float(np.sqrt(-self.worth(counts)))

    def worth(self, counts: Floats) -> float:
        """Return minus the variance."""
        return -float(self._variance(self._total(counts)))

    def worth_with(self, counts: Floats) -> Floats:
        """Return the same with one more shot at each setting, shape (K,)."""
        return -self._variance(self._total(counts) + self.shown)

    def _total(self, counts: Floats) -> Floats:
        return np.asarray(self.known + np.tensordot(counts, self.shown, 1))

    def _variance(self, matrix: Floats) -> Floats:
        scale = np.sqrt(np.maximum(np.diagonal(matrix, axis1=-2, axis2=-1), 1e-300))
        scaled = matrix / scale[..., :, None] / scale[..., None, :]
        unit = np.zeros(matrix.shape[:-1])
        unit[..., self.place] = 1.0
        solved = np.linalg.solve(scaled, unit[..., None])[..., self.place, 0]
        return np.asarray(solved / scale[..., self.place] ** 2)


def sharpen(
    data: PoseData,
    fit: Fit,
    launch: LaunchFit,
    parameter: str,
    settings: Sequence[Setting],
    *,
    target: float | None = None,
) -> Sharpening:
    """Choose the shots that bring the standard error of a parameter down.

    The errors are those of the fit's own linearisation, as the sigmas of `data` give them.

    Parameters
    ----------
    data, fit, launch
        The campaign, its fit with all effects that are believed, and the fit of its launches.
    parameter
        One of the names of the fit's theory.
    settings
        Those that the rig allows.
    target
        Standard error to reach, in the parameter's unit; None: half of what it is.

    Raises
    ------
    ValueError
        The theory has no such parameter.
    """
    place = fit.theory.names.index(parameter)
    drawn = candidates(data, fit, launch, settings)
    shots = foreseen_shots(drawn, fit.theory)
    aim = Sharpness(
        known=with_prior(
            by_shot(data, fit.states, fit.theory).matrix.sum(axis=0), fit.theory.prior[1]
        ),
        shown=drawn.averaged(by_shot(shots, drawn.states, fit.theory).matrix),
        place=place,
    )
    present = aim.sigma(np.zeros(aim.size))
    wanted = present / 2 if target is None else target
    counts = chosen(aim, lambda n: aim.sigma(n) <= wanted, MOST_SHOTS)
    return Sharpening(
        parameter=parameter,
        unit=fit.theory.units[place],
        present=present,
        target=wanted,
        reached=aim.sigma(counts),
        shots=repeated(drawn, counts),
        even=fewest_even(aim.size, lambda n: aim.sigma(n) <= wanted, MOST_EVEN),
    )
