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
from analysis.model.fitting.fit import fit_campaign
from analysis.model.fitting.gauss_newton import Purpose
from analysis.model.fitting.normal import prior_cost
from analysis.model.fitting.robust_fit import RobustFit, robust_fit
from analysis.model.predict.contact import encounter_of
from analysis.model.proposals.admissible import FEWEST_SHOTS, Admitted, admitted
from analysis.model.proposals.channels import Channels, Form, channels_of
from analysis.model.proposals.launch_search import propose_launch
from analysis.model.proposals.proposed import Accepted, Proposed
from analysis.model.proposals.refine import Refitted, Rival, ScoredForm, with_free_constants
from analysis.model.proposals.rivals import (
    Gate,
    apart,
    groups_of,
    least_beside,
    rivals_of,
    score_groups,
)
from analysis.model.proposals.screen import contact_forms, screened
from analysis.model.rank.candidate import Ranking
from analysis.model.rank.leaders import FIRST_LEVEL, LATER_LEVEL, Leader, in_order
from analysis.model.rank.leaders import refitted as refitted_leaders
from analysis.model.rank.ranking import rank
from analysis.model.verdict.part import LEAST_SHARE

MOST_STEPS, MOST_TRIED = 6, 3
PREFERRED = 2.0
"""Deviance by which a form must be better than every effect of the catalogue."""
DROP_LEVEL = 0.0005
MOSTLY = 0.8
"""Share of what is unexplained that a law of contact takes by itself and no form is asked beside:
what forms bring meanwhile is mostly its own. An idle one is dropped again after the next step."""
NAME = "proposal"


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
    state = _begin(robust_fit(data, given), catalogue)
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


def _begin(base: RobustFit, catalogue: Sequence[Effect]) -> _State:
    stage = stage_of(base.data, base.fit)
    evidence = base.evidence
    return _State(evidence, (stage,), (), tuple(catalogue), stage.effects)


def _step(state: _State) -> _State | None:
    """Take in the best form, or an effect of the catalogue that does as well; None: neither."""
    ranking = rank(state.data, state.last.fit, state.catalogue)
    with_law = _with_law(state, ranking)
    if with_law is not None:
        return with_law
    channels = channels_of(state.data, state.last.fit)
    arguments = state.admitted(channels.encounter).arguments
    forms: list[Form] = [*contact_forms(channels, arguments)]
    forms += list(dict.fromkeys(form for form, _ in channels.framed))
    # The zeros of a product move with the shots: the same once more is its main effects.
    taken = {(one.form.group, one.form.shape_name) for one in state.accepted}
    forms = [form for form in forms if (form.group, form.shape_name) not in taken]
    screen = screened(channels, forms, np.random.default_rng(0))
    threshold = screen.threshold(state.level)
    passing = {group for group, score in screen.groups().items() if score >= threshold}
    scored_forms = score_groups(channels, screen, forms) if passing else []
    name = f"{NAME}-{len(state.accepted) + 1}"
    gate = Gate(state.data, state.last, screen, name, _least_drop(state))
    rivals, known = _competed(state, ranking, gate, channels, (scored_forms, forms))
    if known.first is not None and (not rivals or known.worth > rivals[0].worth - PREFERRED):
        leader, stage = known.first
        return _moved(state, stage, whole(leader.data))
    leading = [one for one in apart(rivals) if passing & groups_of(one)]
    for found in leading[:MOST_TRIED]:
        accepted = gate.passed(found, rivals)
        if accepted is not None:
            following = _moved(state, accepted.after, state.data)
            near = accepted.found.worth - ALIAS_WITHIN
            accepted = replace(
                accepted,
                before=following.path[-2],
                after=following.last,
                alike_effects=tuple(x.name for x in known.believed if x.unbiased_delta_chi2 > near),
            )
            return replace(following, accepted=(*state.accepted, accepted))
    return None


def _with_law(state: _State, ranking: Ranking) -> _State | None:
    """Take in a law of contact that comes first and explains most by itself; None: there is none.

    How much is unexplained is chi-squared beyond the degrees of freedom, by the errors as stated.
    """
    fit = state.last.fit
    first = next(iter(ranking.candidates), None)
    if first is None or first.law is None or not first.seen:
        return None
    known = _known(state, ranking, least=first.delta_chi2).first
    if known is None or known[0].delta_chi2 < MOSTLY * (fit.chi2 - fit.freedom):
        return None
    leader, stage = known
    return _moved(state, stage, whole(leader.data))


def _least_drop(state: _State) -> float:
    """Return by how much a form must lower the error: a later one by a share of what was there.

    What asks for less beside a law that is found may be the measurement itself.
    """
    if not state.accepted:
        return 0.0
    return LEAST_SHARE * max(state.accepted[0].before.error.value - 1.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """What the catalogue offers.

    Attributes
    ----------
    first
        The first effect that helps shots left out, and the point of the error path with it.
    believed
        All effects that were refitted and are believed.
    """

    first: tuple[Leader, Stage] | None
    believed: tuple[Leader, ...]

    @property
    def worth(self) -> float:
        return self.first[0].unbiased_delta_chi2 if self.first else 0.0


def _competed(
    state: _State,
    ranking: Ranking,
    gate: Gate,
    channels: Channels,
    asked: tuple[Sequence[ScoredForm], Sequence[Form]],
) -> tuple[list[Rival], _Known]:
    """Return forms and effects of the catalogue, refitted where they may come first or alike.

    Those of a larger expected drop are refitted first: few of the others are worth it then.

    Parameters
    ----------
    asked
        The likeliest forms by their scores, and all forms.
    """
    scored_forms, forms = asked
    fitted = state.data, state.last.fit, gate.name
    helpful = any(gate.may_help(scored) for scored in scored_forms)
    offered = max((c.delta_chi2 for c in ranking.candidates if c.seen), default=0.0)
    if not scored_forms or scored_forms[0].worth < offered:
        known = _beside(state, ranking, scored_forms[0] if scored_forms else None)
        if helpful:
            return rivals_of(fitted, channels, scored_forms, forms, known.worth), known
        return [*scored_forms], known
    rivals: list[Rival] = [*scored_forms]
    if helpful:
        rivals = rivals_of(fitted, channels, scored_forms, forms)
    return rivals, _beside(state, ranking, rivals[0])


def _beside(state: _State, ranking: Ranking, form: Rival | None) -> _Known:
    """Refit effects of the catalogue that may come near a form, and find the first that helps."""
    fit = state.last.fit
    least = max(least_beside(form.worth), 0.0) if form else 0.0
    beat = np.inf
    if isinstance(form, Refitted):
        noise = form.fit.chi2_per_dof
        beat = fit.chi2 + prior_cost(fit.theory) - noise * (form.worth - ALIAS_WITHIN)
    return _known(state, ranking, least=least, beat=beat)


def _known(state: _State, ranking: Ranking, *, least: float, beat: float = np.inf) -> _Known:
    """Refit effects of the catalogue whose expected drop is large enough; the first that helps."""
    fit = state.last.fit
    leaders = refitted_leaders(state.data, fit, ranking, state.level, least=least, beat=beat)
    trusted = [x for x in in_order(leaders) if x.plausible and not x.carried]
    for leader in trusted[:MOST_TRIED]:
        refit = leader.fit
        if not refit.converged:
            if refit.chi2 + prior_cost(refit.theory) > beat:
                continue
            refit = fit_campaign(leader.data, refit.theory, refit)
        stage = stage_of(leader.data, refit)
        if stage.error.value < state.last.error.value:
            return _Known((leader, stage), tuple(trusted))
    return _Known(None, tuple(trusted))


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
                least = float(chi_squared.limit(DROP_LEVEL, len(active.values))) * noise
                rest = fit_campaign(
                    state.data,
                    fit.theory.without_effect(active.effect.name),
                    fit,
                    Purpose(beat=fit.chi2 + prior_cost(fit.theory) + least),
                )
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
