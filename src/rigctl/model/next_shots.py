"""What next shots are to be good for, and the answer as commands and jobs give it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from analysis.effects.effect import Effect, ScatterEffect
from analysis.launch.fit import fit_launch
from analysis.launch.prediction import Limits
from analysis.model.data.poses import PoseData
from analysis.model.design.between import PROBABILITY, tell_apart
from analysis.model.design.candidates import grid
from analysis.model.design.document import NONE, sharpening_document, telling_document
from analysis.model.design.misfit import MisfitError, require_one_that_fits, to_add_first
from analysis.model.design.sharpen import sharpen
from analysis.model.design.undecided import fired_alike, next_after
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.verdict.selection import explain
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError, NotFoundError, SettingsError


@dataclass(frozen=True, slots=True)
class Known:
    """Effects to choose from, and what finds one by its name or raises `NotFoundError`."""

    effects: Sequence[Effect]
    named: Callable[[str], Effect]

    def either(self, name: str) -> Effect | None:
        """Return the effect of a name; None for the base model.

        Raises
        ------
        NotFoundError
            There is none of that name.
        SettingsError
            It is one of the noise, which moves no pose.
        """
        effect = None if name == NONE else self.named(name)
        if isinstance(effect, ScatterEffect):
            raise SettingsError(
                "is in the noise of every shot: no setting tells it from another",
                part="between",
                value=repr(name),
                todo="name an effect that moves the poses",
            )
        return effect


@dataclass(frozen=True, slots=True)
class Question:
    """What next shots are to be good for.

    Attributes
    ----------
    between
        Names of two effects, or `none`; None: the alias set of the verdict.
    sharpen, to
        A parameter in place of effects, and the standard error to reach, in its unit.
    names
        Effects in the model already.
    probability
        Of naming the right one of two effects.
    """

    between: tuple[str, str] | None = None
    sharpen: str | None = None
    to: float | None = None
    names: tuple[str, ...] = ()
    probability: float = PROBABILITY

    def check(self) -> None:
        """Refuse what contradicts itself.

        Raises
        ------
        SettingsError
            Two questions at once, an effect against itself, or an error to reach of nothing.
        """
        if self.between is not None and self.sharpen is not None:
            raise SettingsError(
                "two questions at once", part="sharpen", todo="ask between or sharpen"
            )
        if self.to is not None and self.sharpen is None:
            raise SettingsError("belongs to a parameter", part="to", todo="name one with sharpen")
        if self.between is not None and self.between[0] == self.between[1]:
            raise SettingsError(
                "names one thing twice",
                part="between",
                value=repr(self.between[0]),
                todo=f"name two effects, or one and {NONE}",
            )
        twice = sorted({*(self.between or ())} & {*self.names})
        if twice:
            raise SettingsError(
                "is among the effects of the model already",
                part="between",
                value=repr(twice[0]),
                todo="leave it out of with",
            )


def answer(data: PoseData, question: Question, known: Known, limits: Limits) -> Json:
    """Return the document of the next shots, but for the campaign's name.

    Raises
    ------
    NotFoundError
        No effect or parameter has that name, or the verdict leaves nothing to tell apart.
    AnalysisInputError
        Neither of two effects fits the campaign.
    LaunchRefusedError
        The settings of the campaign do not let shots be foretold.
    EffectFault
        An effect of the user's own fails.
    """
    if question.between is None and question.sharpen is None:
        return _undecided(data, known, limits)
    in_model = [known.named(name) for name in question.names]
    pair = [known.either(name) for name in question.between or ()]
    found = robust_fit(data, in_model)
    if not isinstance(found.data, PoseData):
        raise TypeError("a robust fit of poses gave none back")
    launch = fit_launch(found.data, found.fit)
    settings = grid(limits, alike=fired_alike(data))
    if question.sharpen is not None:
        _require_parameter(question.sharpen, found.fit.theory.names)
        sharper = sharpen(
            found.data, found.fit, launch, question.sharpen, settings, target=question.to
        )
        return {**sharpening_document(sharper), **_fits(found.data, found.fit, known)}
    try:
        planned = tell_apart(
            found.data,
            found.fit,
            launch,
            (pair[0], pair[1]),
            settings,
            probability=question.probability,
        )
    except MisfitError as error:
        raise _neither_fits(error, found.data, question, known) from error
    return telling_document(planned)


def _neither_fits(
    error: MisfitError, data: PoseData, question: Question, known: Known
) -> AnalysisInputError:
    first = to_add_first(data, error.fit, known.effects, question.between or ())
    one, other = (_named(name) for name in question.between or ())
    return AnalysisInputError(
        f"neither {one} nor {other} fits: with the better of them {error}. Something else is "
        "missing, and it decides which of the two comes nearer",
        part="between",
        todo=(
            "ask for the verdict (model explain)"
            if first is None
            else f"add what promises most first: with {first}"
        ),
    )


def _fits(data: PoseData, fit: Fit, known: Known) -> Json:
    """Return whether the model fits, and what to add first where it does not."""
    document = {"chi2_per_dof": fit.chi2_per_dof, "p_chi2": fit.p_chi2}
    try:
        require_one_that_fits(data, [fit])
    except MisfitError:
        return {**document, "fits": False, "add_first": to_add_first(data, fit, known.effects)}
    return {**document, "fits": True, "add_first": None}


def _named(name: str) -> str:
    return "the model without it" if name == NONE else name


def _undecided(data: PoseData, known: Known, limits: Limits) -> Json:
    planned = next_after(explain(data, known.effects), known.effects, limits)
    if planned is None:
        raise NotFoundError(
            "the verdict leaves no effects to tell apart",
            todo="name two with between, or a parameter with sharpen",
        )
    return telling_document(planned)


def _require_parameter(name: str, names: Sequence[str]) -> None:
    if name not in names:
        raise NotFoundError(
            "the fit has no parameter of this name",
            part="sharpen",
            value=repr(name),
            todo=f"choose one of {', '.join(names)}; effects are added by with",
        )
