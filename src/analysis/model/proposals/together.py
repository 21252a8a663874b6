"""Several campaigns asked at once: what they share, and what each has for itself.

A campaign is read twice and alone: first where its shots lie and which effects of the catalogue it
has, then the sums M and g of all columns about its own fit. Both are small and add up, so that many
campaigns are a map and a reduce.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis import chi_squared
from analysis.effects.catalogue import CATALOGUE
from analysis.effects.effect import Effect
from analysis.errors import ProposalRefusedError, counted
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import whole
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.proposals.admissible import FEWEST_SHOTS, admitted
from analysis.model.proposals.arguments import Argument
from analysis.model.proposals.channels import Channels, Sums, channels_of
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.forms.impulses import IMPULSES
from analysis.model.proposals.forms.shapes import Spread
from analysis.model.proposals.propose import known_effects
from analysis.model.proposals.refine import OF_IMPULSE
from analysis.model.proposals.screen import (
    Screen,
    Spreads,
    columns_of,
    contact_forms,
    largest_by_chance,
    spreads_of,
)
from analysis.model.rank.leaders import FIRST_LEVEL, LATER_LEVEL

T = TypeVar("T")
Mapper = Callable[[Callable[[Any], Any], Sequence[Any]], Iterable[Any]]
"""Calls a function with every campaign: `map`, that of a pool of processes or of a cluster."""
Label = tuple[str, str, str, tuple[float, ...]]
"""Slot, argument, shape and constants of a form."""

MOST = 4
LEAST_DIRECTION = 1e-6
"""Of columns that are projected out: below it stands rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Where the shots of one campaign lie, how many there are, and names of its effects."""

    spreads: Spreads
    shots: int
    effects: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class OwnSums:
    """M and g of all columns of one campaign, in units of its noise, and the forms' names."""

    labels: tuple[Label, ...]
    sums: Sums


@dataclass(frozen=True, slots=True, eq=False)
class SharedForm:
    """One form in all campaigns.

    Attributes
    ----------
    slot, argument, shape, constants
        The form; its constants are those that were tried, not fitted.
    amplitude, sigma
        That all campaigns share.
    each
        Amplitude and sigma in every campaign; infinite sigma: it says nothing of it.
    p_familywise
        Of the shared amplitude, every form looked at.
    p_alike
        Chance of amplitudes that differ so much where all campaigns share one.
    """

    slot: str
    argument: str
    shape: str
    constants: tuple[float, ...]
    amplitude: float
    sigma: float
    each: tuple[tuple[float, float], ...]
    p_familywise: float
    p_alike: float


@dataclass(frozen=True, slots=True, eq=False)
class Together:
    """What several campaigns ask for together.

    Attributes
    ----------
    forms
        One for each slot and argument.
    effects
        Of each campaign the names of the effects in its own fit: those given, and those of the
        catalogue that it has.
    """

    forms: tuple[SharedForm, ...]
    effects: tuple[tuple[str, ...], ...]


def propose_together(
    campaigns: Sequence[Data], given: Sequence[Effect], mapper: Mapper = map
) -> Together:
    """Return the forms that several campaigns ask for together, beside what each is known to have.

    Parameters
    ----------
    given
        Effects that are known to be in all of them.
    mapper
        Where the campaigns are worked on.

    Raises
    ------
    ProposalRefusedError
        A campaign has too few shots, or they share no argument.
    """
    return propose_read(campaigns, partial(_beside, given=tuple(given)), mapper)


def propose_read(
    campaigns: Sequence[T],
    read: Callable[[T], tuple[Data, tuple[Effect, ...]]],
    mapper: Mapper = map,
) -> Together:
    """Return the same of campaigns that are read where they are worked on, so that none travels.

    Parameters
    ----------
    read
        From what names a campaign to its data, and the effects that are known to be in it.

    Raises
    ------
    ProposalRefusedError
        As `propose_together`.
    """
    placed: list[Placed] = list(mapper(partial(_place_read, read=read), campaigns))
    spreads = joined(placed)
    if not spreads:
        raise ProposalRefusedError("these campaigns share no argument that changes in all of them")
    effects = tuple(one.effects for one in placed)
    asked = partial(_sums_read, read=read, spreads=spreads)
    sums = list(mapper(asked, list(zip(campaigns, effects, strict=True))))
    return Together(tuple(shared_forms(sums)), effects)


def _beside(data: Data, given: tuple[Effect, ...]) -> tuple[Data, tuple[Effect, ...]]:
    return data, given


def _place_read(campaign: T, read: Callable[[T], tuple[Data, tuple[Effect, ...]]]) -> Placed:
    return place(*read(campaign))


def _sums_read(
    campaign: tuple[T, tuple[str, ...]],
    read: Callable[[T], tuple[Data, tuple[Effect, ...]]],
    spreads: Spreads,
) -> OwnSums:
    data, given = read(campaign[0])
    return own_sums(data, _named(given, campaign[1]), spreads)


def _named(given: Sequence[Effect], names: Sequence[str]) -> tuple[Effect, ...]:
    """Return the effects given, and those of the catalogue that have other ones of these names."""
    known = {effect.name for effect in given}
    more = (effect for effect in CATALOGUE if effect.name in names and effect.name not in known)
    return (*given, *more)


def place(data: Data, given: tuple[Effect, ...]) -> Placed:
    """Return where the shots of a campaign lie, and what it is known to have: the first map."""
    if len(data.shots) < FEWEST_SHOTS:
        raise ProposalRefusedError(
            f"a campaign of {counted(len(data.shots), 'shot')} takes no part: at least "
            f"{FEWEST_SHOTS} are needed"
        )
    effects = known_effects(data, given, CATALOGUE)
    channels = _about_fit(data, _named(given, effects))
    kept = _arguments(data, channels)
    return Placed(spreads_of(channels, kept), len(channels.encounter.e), effects)


def own_sums(data: Data, given: tuple[Effect, ...], spreads: Spreads) -> OwnSums:
    """Return the sums of a campaign on forms that all campaigns share: the second map."""
    channels = _about_fit(data, given)
    arguments = [a for a in _arguments(data, channels) if a.key in spreads]
    forms = contact_forms(channels, arguments, spreads)
    columns = columns_of(forms)
    sums = channels.summed([channels.weights(form, number) for form, number in columns])
    scale = channels.noise_scale**2
    labels = tuple(_label(form) for form, _ in columns if isinstance(form, ContactForm))
    return OwnSums(labels, Sums(sums.matrix / scale, sums.gradient / scale, sums.raw / scale))


def joined(placed: Sequence[Placed]) -> dict[tuple[str, str], Spread]:
    """Return the common spread of every argument that all campaigns have: the first reduce."""
    shared = set.intersection(*(set(one.spreads) for one in placed))
    weights = np.array([one.shots for one in placed], dtype=np.float64)
    return {
        key: Spread(
            min(one.spreads[key].low for one in placed),
            max(one.spreads[key].high for one in placed),
            float(np.average([one.spreads[key].mean for one in placed], weights=weights)),
        )
        for key in placed[0].spreads
        if key in shared
    }


def shared_forms(own: Sequence[OwnSums], seed: int = 0) -> list[SharedForm]:
    """Return what the sums of all campaigns ask for, step by step: the second reduce.

    After each step all that a slot and an argument can do is projected out in every campaign: what
    the constants that are tried do not quite hit shall not come back as something else.
    """
    labels, found = own[0].labels, list[SharedForm]()
    while len(found) < MOST:
        total = own[0].sums
        for other in own[1:]:
            total = total + other.sums
        seen = np.flatnonzero(total.seen)
        kept = total.of(seen)
        root = np.sqrt(np.diag(kept.matrix))
        scores = kept.gradient / root
        correlation = kept.matrix / root[:, None] / root[None, :]
        chance = np.sort(largest_by_chance(correlation, np.random.default_rng(seed)))
        screen = Screen((), np.zeros(0), chance)
        charge = OF_IMPULSE * np.array([labels[column][0] in IMPULSES for column in seen])
        best = int(np.argmax(scores**2 - charge))
        if abs(scores[best]) < screen.threshold(LATER_LEVEL if found else FIRST_LEVEL):
            break
        column, p_value = int(seen[best]), screen.p_familywise(float(scores[best]))
        found.append(_shared(labels[column], column, own, p_value))
        group = np.array([label[:2] == labels[column][:2] for label in labels])
        own = [OwnSums(labels, _without(one.sums, group)) for one in own]
    return found


def _without(sums: Sums, group: NDArray[np.bool_]) -> Sums:
    """Return sums with all that some columns can do projected out."""
    across = sums.matrix[:, group]
    scale = np.sqrt(np.maximum(np.diag(sums.matrix)[group], 1e-300))
    inner = sums.matrix[np.ix_(group, group)] / scale[:, None] / scale[None, :]
    inverse = np.linalg.pinv(inner, rcond=LEAST_DIRECTION, hermitian=True)
    along = across / scale[None, :]
    matrix = sums.matrix - along @ inverse @ along.T
    gradient = sums.gradient - along @ (inverse @ (sums.gradient[group] / scale))
    return Sums(matrix, gradient, sums.raw)


def _shared(
    label: Label,
    column: int,
    own: Sequence[OwnSums],
    p_familywise: float,
) -> SharedForm:
    information = np.array([one.sums.matrix[column, column] for one in own])
    gradient = np.array([one.sums.gradient[column] for one in own])
    told = np.array([bool(one.sums.seen[column]) for one in own])
    information, gradient = information[told], gradient[told]
    amplitude = float(gradient.sum() / information.sum())
    # What separate amplitudes bring beyond a shared one.
    apart = float((gradient**2 / information).sum() - gradient.sum() ** 2 / information.sum())
    each = [(0.0, np.inf)] * len(own)
    for place_, m, g in zip(np.flatnonzero(told), information, gradient, strict=True):
        each[place_] = float(g / m), float(1 / np.sqrt(m))
    slot, argument, shape, constants = label
    return SharedForm(
        slot=slot,
        argument=argument,
        shape=shape,
        constants=constants,
        amplitude=amplitude,
        sigma=float(1 / np.sqrt(information.sum())),
        each=tuple(each),
        p_familywise=p_familywise,
        p_alike=float(chi_squared.chance_of_more(apart, len(information) - 1)),
    )


def _about_fit(data: Data, given: tuple[Effect, ...]) -> Channels:
    found = robust_fit(data, given)
    return channels_of(whole(found.data), found.fit)


def _arguments(data: Data, channels: Channels) -> list[Argument]:
    return list(
        admitted(
            channels.encounter,
            scalars=isinstance(data, ContactTable) and data.scalars,
            one_frame=isinstance(data, PoseData) and data.slow.one_body_frame,
        ).arguments
    )


def _label(form: ContactForm) -> Label:
    return form.slot, form.argument, form.shape_name, form.constants
