"""A stated form tested on shots that it was not chosen on, with an ordinary p."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis import chi_squared
from analysis.effects.effect import Effect
from analysis.errors import LaunchRefusedError, ProposalRefusedError, counted
from analysis.launch.fit import fit_launch, settled
from analysis.model.data.evidence import stage_of, weighed_again
from analysis.model.data.stream import whole
from analysis.model.data.tables import Data
from analysis.model.fitting.adding import added
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.proposals.launch_search import errors_left_out, fall_of
from analysis.model.proposals.stated import LAUNCH, Statement
from analysis.quantity import Quantity

FEWEST = 3
LEVEL = 0.01
"""Of one form, stated beforehand: no other was looked at."""


@dataclass(frozen=True, slots=True, eq=False)
class Confirmation:
    """What other shots say of a form.

    Attributes
    ----------
    beside
        Names of the effects that were fitted too.
    shots
        How many were used.
    delta_chi2
        Of chi-squared that the form brings, in units of the noise.
    p_value
        Chance of such a fall where the form is not there.
    error_before, error_after
        On shots left out, without and with it.
    parameters
        As these shots alone have them.
    """

    effect: Effect
    beside: tuple[str, ...]
    shots: int
    delta_chi2: float
    p_value: float
    error_before: float
    error_after: float
    parameters: dict[str, Quantity]

    @property
    def confirmed(self) -> bool:
        """Whether chance alone would not do it, and shots left out agree."""
        return self.p_value < LEVEL and self.error_after < self.error_before


def without_shots(data: Data, seen: set[int]) -> Data:
    """Return the shots that a form has not seen.

    Raises
    ------
    ProposalRefusedError
        There are none, or next to none.
    """
    fresh: NDArray[np.bool_] = np.array([int(number) not in seen for number in data.shots])
    if fresh.sum() < FEWEST:
        raise ProposalRefusedError(
            f"{counted(int(fresh.sum()), 'shot')} of these did not take part in the choice of the "
            f"form, and at least {FEWEST} are needed: fire its next shots first"
        )
    return data.of_shots(fresh)


def confirm_stated(data: Data, given: Sequence[Effect], stated: Statement) -> Confirmation:
    """Test a form that is stated on shots that it was not chosen on.

    Raises
    ------
    ProposalRefusedError
        The campaign has not what it follows; of a form of the launch, its settings are not known.
    """
    name = f"stated-{stated.slot}"
    if stated.slot != LAUNCH:
        return confirm(data, given, stated.form(data).effect(name))
    base = robust_fit(data, given)
    told = whole(base.data)
    try:
        launch = fit_launch(told, base.fit)
    except LaunchRefusedError as error:
        raise ProposalRefusedError(f"the launches cannot be judged: {error}") from error
    effect = stated.launch_form(told, np.isin(told.shots, launch.shots)).effect(name)
    after = settled(launch.theory.with_effect(effect), launch)
    errors = errors_left_out(launch, after)
    return _confirmation(
        (effect, given), len(launch.shots), fall_of(launch, after), errors, after.parameters()
    )


def confirm(data: Data, given: Sequence[Effect], effect: Effect) -> Confirmation:
    """Test one form on shots that it was not chosen on, beside effects that are given.

    Shots that look bad without the form, and not with it, count in both fits.
    """
    base = robust_fit(data, given)
    fitted, fit = added(base.data, base.fit, effect)
    path = [stage_of(base.data, base.fit), stage_of(fitted, fit)]
    evidence, (before, after) = weighed_again(base.evidence, path, fitted.jitter_s)
    delta_chi2 = max((before.fit.chi2 - after.fit.chi2) / max(after.fit.chi2_per_dof, 1e-12), 0.0)
    errors = before.error.value, after.error.value
    shots, found = len(evidence.data.shots), after.fit.parameters()
    return _confirmation((effect, given), shots, delta_chi2, errors, found)


def _confirmation(
    tested: tuple[Effect, Sequence[Effect]],
    shots: int,
    delta_chi2: float,
    errors: tuple[float, float],
    parameters: Mapping[str, Quantity],
) -> Confirmation:
    effect, given = tested
    own = f"{effect.name}."
    return Confirmation(
        effect=effect,
        beside=tuple(one.name for one in given),
        shots=shots,
        delta_chi2=delta_chi2,
        p_value=float(chi_squared.chance_of_more(max(delta_chi2, 0.0), len(effect.parameters))),
        error_before=errors[0],
        error_after=errors[1],
        parameters={
            name.removeprefix(own): quantity
            for name, quantity in parameters.items()
            if name.startswith(own)
        },
    )
