"""What depends on what, beyond the catalogue: proposed step by step, each held against chance.

Effects of the catalogue compete in every step: where one does as well as the best form, it is the
one that goes in, so that no known effect is proposed as a new law.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis import chi_squared
from analysis.collision.operator import Encounter
from analysis.effects.effect import Effect
from analysis.errors import ProposalRefusedError, counted
from analysis.model.data.evidence import Evidence, Stage, stage_of, weighed_again
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import whole
from analysis.model.data.tables import ContactTable, Data
from analysis.model.fitting.adding import ALIAS_WITHIN
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.fitting.robust_fit import Judged, judged
from analysis.model.predict.contact import encounter_of
from analysis.model.proposals.admissible import FEWEST_SHOTS, Admitted, admitted
from analysis.model.proposals.blocks import falls_on_blocks
from analysis.model.proposals.channels import Form, channels_of
from analysis.model.proposals.forms.impulses import IMPULSES
from analysis.model.proposals.launch_search import LaunchProposal, propose_launch
from analysis.model.proposals.products import main_groups
from analysis.model.proposals.refine import (
    CARRIERS,
    Promise,
    Refitted,
    with_free_constants,
)
from analysis.model.proposals.rivals import apart, rivals_of
from analysis.model.proposals.screen import Screen, contact_forms, screened
from analysis.model.rank.candidate import believed
from analysis.model.rank.leaders import FIRST_LEVEL, LATER_LEVEL, Leader, in_order
from analysis.model.rank.leaders import refitted as refitted_leaders
from analysis.model.rank.ranking import rank
from analysis.model.structure.influence import most_carried
from analysis.model.verdict.part import LEAST_SHARE
from analysis.quantity import Quantity

MOST_STEPS, MOST_TRIED = 6, 3
PREFERRED = 2.0
"""Deviance by which a form must be better than every effect of the catalogue."""
DROP_LEVEL = 0.0005
LEAST_SIGMAS = 3.0
"""An amplitude nearer to zero than so many of its errors is not determined."""
NAME = "proposal"


@dataclass(frozen=True, slots=True, eq=False)
class Accepted:
    """One form that went in.

    Attributes
    ----------
    found
        The form with its constants, and its name in the fit.
    shapes
        Names of the shapes that these shots do not tell apart, the best first.
    alike, alike_effects
        Slots and arguments that they do not tell from it, and effects of the catalogue.
    p_familywise
        Of its score, when it was found.
    before, after
        The stages of the error path.
    freed
        The fit in which its constants are free: their errors.
    rival
        The best form of another slot or argument that these shots do not tell from it and others
        may: none that is an impulse where this is the coefficient that sets it.
    """

    found: Refitted
    shapes: tuple[str, ...]
    alike: tuple[tuple[str, str], ...]
    alike_effects: tuple[str, ...]
    p_familywise: float
    before: Stage
    after: Stage
    freed: Fit
    rival: Form | None = None

    @property
    def form(self) -> Form:
        """The form."""
        return self.found.form

    @property
    def name(self) -> str:
        """Of its effect in the fit."""
        return self.found.name

    @property
    def quantities(self) -> dict[str, Quantity]:
        """Amplitudes and constants by symbol, with their standard errors.

        Where a fit cannot follow a constant, as the place of a step between two shots, its value is
        the best that was tried.
        """
        own = f"{self.name}."
        found = {
            name.removeprefix(own): quantity
            for name, quantity in self.freed.parameters().items()
            if name.startswith(own)
        }
        scales = self.form.freed(self.name).parameters[len(self.form.symbols) :]
        values = self.form.constants[len(self.form.constants) - len(scales) :]
        held = zip(scales, values, self.found.promise.widths, strict=False)
        for scale, value, width in held:
            found.setdefault(scale.symbol, Quantity(float(value), width, scale.unit))
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Proposed:
    """What is concluded.

    Attributes
    ----------
    accepted
        The forms, in the order in which they went in.
    effects
        Names of the catalogue's effects in the fit: those asked for, and those that went in.
    launch
        What the launches depend on, judged by themselves.
    """

    evidence: Evidence
    path: tuple[Stage, ...]
    accepted: tuple[Accepted, ...]
    effects: tuple[str, ...]
    admitted: Admitted
    launch: tuple[LaunchProposal, ...] = ()

    @property
    def fit(self) -> Fit:
        """The fit with everything in."""
        return self.path[-1].fit

    @property
    def data(self) -> Data:
        """What was fitted."""
        return whole(self.evidence.data)

    @property
    def encounter(self) -> Encounter:
        """How the spheres of every shot meet."""
        return encounter_of(self.data, self.fit.states, self.fit.theory)


def propose(
    data: Data,
    given: Sequence[Effect],
    catalogue: Sequence[Effect],
    progress: Callable[[str], None] = lambda _: None,
) -> Proposed:
    """Propose what depends on what, beside the effects given and those of the catalogue.

    Raises
    ------
    ProposalRefusedError
        There are too few shots.
    """
    found = _searched(data, given, catalogue, progress).proposed()
    progress("asking the launches")
    arguments = found.admitted.arguments
    return replace(found, launch=propose_launch(found.data, found.fit, found.encounter, arguments))


def known_effects(
    data: Data, given: Sequence[Effect], catalogue: Sequence[Effect]
) -> tuple[str, ...]:
    """Return the names of the effects given, and of those that the same search takes in.

    Raises
    ------
    ProposalRefusedError
        There are too few shots.
    """
    state = _searched(data, given, catalogue, lambda _: None)
    names = {one.name for one in state.accepted}
    return tuple(name for name in state.last.effects if name not in names)


def _searched(
    data: Data,
    given: Sequence[Effect],
    catalogue: Sequence[Effect],
    progress: Callable[[str], None],
) -> _State:
    """Take in forms and effects of the catalogue for as long as one is asked for."""
    shots = len(data.shots)
    if shots < FEWEST_SHOTS:
        raise ProposalRefusedError(
            f"no law can be proposed from {counted(shots, 'shot')}: at least {FEWEST_SHOTS} are "
            "needed, at several settings"
        )
    progress("fitting what is known")
    state = _begin(judged(data, given), catalogue)
    while len(state.path) <= MOST_STEPS:
        progress(f"scoring forms, {len(state.path) - 1} steps taken")
        following = _step(state)
        if following is None:
            break
        state = _without_idle(following)
    return state


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """How far the search has come."""

    evidence: Evidence
    path: tuple[Stage, ...]
    accepted: tuple[Accepted, ...]
    catalogue: tuple[Effect, ...]
    given: tuple[str, ...]

    @property
    def last(self) -> Stage:
        return self.path[-1]

    @property
    def data(self) -> Data:
        return whole(self.evidence.data)

    @property
    def level(self) -> float:
        return LATER_LEVEL if self.accepted else FIRST_LEVEL

    def admitted(self, encounter: Encounter) -> Admitted:
        return admitted(
            encounter,
            scalars=isinstance(self.data, ContactTable) and self.data.scalars,
            one_frame=isinstance(self.data, PoseData) and self.data.slow.one_body_frame,
            unused=self.data.unused,
        )

    def proposed(self) -> Proposed:
        names = {one.name for one in self.accepted}
        fit, accepted = self.last.fit, list[Accepted]()
        for one in self.accepted:
            # Its constants as they are beside everything that went in after it.
            if one.after is not self.last or len(self.accepted) > 1:
                beside = replace(one.found, fit=fit)
                found, freed = with_free_constants(self.data, beside)
                fit, one = found.fit, replace(one, found=found, freed=freed)  # noqa: PLW2901
            accepted.append(one)
        path = self.path
        if fit is not self.last.fit:
            path = (*path[:-1], stage_of(self.data, fit))
        return Proposed(
            self.evidence,
            path,
            tuple(accepted),
            tuple(name for name in self.last.effects if name not in names),
            self.admitted(encounter_of(self.data, fit.states, fit.theory)),
        )


def _begin(base: Judged, catalogue: Sequence[Effect]) -> _State:
    stage = stage_of(base.data, base.fit)
    evidence = base.evidence
    return _State(evidence, (stage,), (), tuple(catalogue), stage.effects)


def _step(state: _State) -> _State | None:
    """Take in the best form, or an effect of the catalogue that does as well; None: neither."""
    channels = channels_of(state.data, state.last.fit)
    arguments = state.admitted(channels.encounter).arguments
    forms: list[Form] = [*contact_forms(channels, arguments)]
    forms += list(dict.fromkeys(form for form, _ in channels.framed))
    # The zeros of a product move with the shots: the same once more is its main effects.
    taken = {(one.form.group, one.form.shape_name) for one in state.accepted}
    forms = [form for form in forms if (form.group, form.shape_name) not in taken]
    screen = screened(channels, forms, np.random.default_rng(0))
    rivals = list[Refitted]()
    if max(screen.groups().values(), default=0.0) >= screen.threshold(state.level):
        name = f"{NAME}-{len(state.accepted) + 1}"
        rivals = rivals_of((state.data, state.last.fit, name), channels, screen, forms)
    leader, leaders = _leader(state)
    if leader is not None and (not rivals or leader[0].unbiased_fall > rivals[0].worth - PREFERRED):
        return _moved(state, leader[1], whole(leader[0].data))
    passing = {g for g, z in screen.groups().items() if z >= screen.threshold(state.level)}
    leading = [one for one in apart(rivals) if passing & _told_by(one)]
    for found in leading[:MOST_TRIED]:
        accepted = _accepted(state, found, rivals, screen)
        if accepted is not None:
            following = _moved(state, accepted.after, state.data)
            near = accepted.found.worth - ALIAS_WITHIN
            accepted = replace(
                accepted,
                before=following.path[-2],
                after=following.last,
                alike_effects=tuple(x.name for x in leaders if x.unbiased_fall > near),
            )
            return replace(following, accepted=(*state.accepted, accepted))
    return None


def _accepted(
    state: _State, found: Refitted, rivals: Sequence[Refitted], screen: Screen
) -> Accepted | None:
    """Return a form that is determined, is no few shots' own, and helps shots left out."""
    data, before = state.data, state.last
    if _carried(found.promise, len(data.shots)):
        return None
    least = found.worth - ALIAS_WITHIN
    found, freed = with_free_constants(data, found)
    if not _determined(found):
        return None
    after = stage_of(data, found.fit)
    gains = np.sort(before.error.by_shot - after.error.by_shot)
    fall = before.error.value - after.error.value
    # Without the two that gain most, the others must gain too.
    if fall <= _least_fall(state) or gains[:-CARRIERS].sum() <= 0:
        return None
    if not falls_on_blocks(data, before.fit, found.fit):
        return None
    near = [one for one in rivals if one.worth > least]
    own = [one.form.shape_name for one in near if one.form.group == found.form.group]
    others = [one.form for one in near if one.form.group != found.form.group]
    groups = screen.groups()
    score = max((groups.get(group, 0.0) for group in _told_by(found)), default=0.0)
    return Accepted(
        found=found,
        shapes=tuple(dict.fromkeys([found.form.shape_name, *own])),
        alike=tuple(dict.fromkeys(form.group for form in others)),
        alike_effects=(),
        p_familywise=screen.p_familywise(score),
        before=before,
        after=after,
        freed=freed,
        rival=next((form for form in others if not _nearly_the_same(form, found.form)), None),
    )


def _told_by(found: Refitted) -> set[tuple[str, str]]:
    """Return the groups whose scores tell of a form: of a freed product its arguments' too."""
    own = {found.form.group}
    return own | main_groups(found.form) if found.promise.zeros_sought else own


def _nearly_the_same(first: Form, second: Form) -> bool:
    """Whether an impulse and the coefficient that sets it follow the same: no shots part them."""
    impulses = sum(form.slot in IMPULSES for form in (first, second))
    return first.argument == second.argument and impulses == 1


def _least_fall(state: _State) -> float:
    """Return by how much a form must lower the error: a later one by a share of what was there.

    What asks for less beside a law that is found may be the measurement itself.
    """
    if not state.accepted:
        return 0.0
    return LEAST_SHARE * max(state.accepted[0].before.error.value - 1.0, 0.0)


def _carried(promise: Promise, shots: int) -> bool:
    """Whether two shots hold most of a promise, and the others alone say next to nothing."""
    rest = promise.fall * (1.0 - promise.carried_share)
    return promise.carried_share > most_carried(shots) and rest < LEAST_SIGMAS**2


def _determined(found: Refitted) -> bool:
    """Whether the amplitudes are in their ranges, and the largest is far from zero."""
    fit, count = found.fit, len(found.form.symbols)
    values = fit.theory.vector[-count:]
    sigmas = np.sqrt(np.diag(fit.covariance))[-count:] * np.sqrt(fit.chi2_per_dof)
    far = np.abs(values) > LEAST_SIGMAS * sigmas
    return bool(far.any()) and believed(found.form.effect(found.name), values, sigmas)


def _leader(state: _State) -> tuple[tuple[Leader, Stage] | None, list[Leader]]:
    """Return the first effect of the catalogue that helps shots left out, and all believed ones."""
    ranking = rank(state.data, state.last.fit, state.catalogue)
    leaders = refitted_leaders(state.data, state.last.fit, ranking, state.level)
    trusted = [x for x in in_order(leaders) if x.plausible and not x.carried]
    for leader in trusted[:MOST_TRIED]:
        fit = leader.fit
        if not fit.converged:
            fit = fit_campaign(leader.data, fit.theory, fit)
        stage = stage_of(leader.data, fit)
        if stage.error.value < state.last.error.value:
            return (leader, stage), trusted
    return None, trusted


def _moved(state: _State, stage: Stage, data: Data) -> _State:
    """Return the state a stage on, shots and frames judged by the theory as it then is."""
    evidence, path = weighed_again(state.evidence, [*state.path, stage], data.jitter_s)
    return replace(state, evidence=evidence, path=tuple(path))


def _without_idle(state: _State) -> _State:
    """Drop what a later step has made superfluous, worst first; what was given stays."""
    while True:
        fit, noise = state.last.fit, max(state.last.fit.chi2_per_dof, 1e-12)
        losses = {}
        for active in fit.theory.active[:-1]:
            if active.effect.name not in state.given:
                rest = fit_campaign(state.data, fit.theory.without_effect(active.effect.name), fit)
                chance = chi_squared.chance_of_more(
                    (rest.chi2 - fit.chi2) / noise, len(active.values)
                )
                losses[active.effect.name] = float(chance), rest
        if not losses:
            return state
        worst = max(losses, key=lambda name: losses[name][0])
        if losses[worst][0] < DROP_LEVEL:
            return state
        state = replace(
            state,
            path=(*state.path, stage_of(state.data, losses[worst][1])),
            accepted=tuple(one for one in state.accepted if one.name != worst),
        )
