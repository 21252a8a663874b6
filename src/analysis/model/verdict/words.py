"""A verdict in words that a student understands."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.model.fitting.nuisance_words import alarm_sentences
from analysis.model.structure.alarm import FEWEST
from analysis.model.structure.influence import FEW
from analysis.quantity import Quantity
from analysis.schema.verdict import SeenCandidate, VerdictReport

STRIKING = 0.01
"""Chance below which a candidate's expected drop is mentioned."""
RARE = 0.1
"""Chance of a chi-squared below which nobody reads that nothing is missing."""
COMPARABLE = 0.5
"""A candidate that is not plausible is mentioned from this share of the best one's drop on."""


def verdict_sentence(found: VerdictReport, *, errors: bool = True) -> str:
    """Say the verdict; without `errors` where they stand beside it."""
    name, used = found.campaign, found.used
    if used < FEWEST:
        return f"{name}: {too_few(used)}{_would_explain(found)}"
    if found.verdict == "none":
        return f"{name}: {_nothing(found)}"
    if found.verdict == "effect":
        several = len(found.effects) > 1
        what = "missing effects are" if several else "missing effect is"
        return f"{name}: the {what} {_listed(found.effects)}{_fall(found) if errors else ''}."
    if found.verdict == "alias":
        return f"{name}: {_alike(found)}: these shots cannot tell{_fall(found) if errors else ''}."
    return _unexplained(found)


def _would_explain(found: VerdictReport) -> str:
    """Say what so few shots would be explained by, where anything explains them."""
    if not found.effects:
        return ""
    return f" {_listed(found.effects)} would explain it as well."


def doubts(found: VerdictReport) -> list[str]:
    """Say what few shots leave open, which candidates have implausible sizes, and what alarms.

    These are never hidden; plausibility only decides which of two alike is tried first.
    """
    alarms = alarm_sentences(found.alarms)
    return [*alarms, *_of_few(found), *_not_believed(found), *_of_images(found)]


def too_few(used: int) -> str:
    """Say that so few shots tell nothing, and how many would."""
    shots = "1 shot is" if used == 1 else f"{used} shots are"
    return (
        f"{shots} too few to tell what is missing: what stands out may be an error of "
        f"{'its' if used == 1 else 'their'} own. Add {FEWEST - used} at least, and better "
        f"{FEW + 1 - used}, at several speeds and angles: pressures and offsets, or heights of a "
        "fall."
    )


def _of_few(found: VerdictReport) -> list[str]:
    """Say what to think of what a few shots leave over where the verdict does not count it."""
    used, verdict = found.used, found.verdict
    if used > FEW or used < FEWEST or verdict == "unexplained" or not found.structure:
        return []
    where = found.structure[0]
    return [
        f"What is left shows most in {where.channel} against {where.covariate}, but two of "
        f"the {used} shots carry it: an error of their own, or something that more than {FEW} "
        "shots would tell."
    ]


def _not_believed(found: VerdictReport) -> list[str]:
    if found.verdict not in {"effect", "alias"}:
        return []
    falls = {c.effect: c.delta_chi2 for c in found.candidates}
    named = {*found.effects, *found.alias_set}
    best = max((falls.get(name, 0.0) for name in named), default=0.0)
    return [
        _doubt(c)
        for c in found.candidates
        if not c.plausible
        and c.effect not in named
        and c.p_familywise < STRIKING
        and c.delta_chi2 > COMPARABLE * best
    ]


def _of_images(found: VerdictReport) -> list[str]:
    return [
        f"{c.effect} by itself would bring chi-squared down by {c.delta_chi2:.0f}, but "
        f"moves places by at most {c.moved_m * 1e6:.1f} um, as "
        "slow errors of the images do: it is taken for theirs."
        for c in found.candidates
        if c.moved_m is not None and c.of_measurement and c.p_familywise < STRIKING
    ]


def _doubt(candidate: SeenCandidate) -> str:
    unit = "" if candidate.unit == "1" else f" {candidate.unit}"
    size = Quantity(candidate.amplitude, candidate.sigma, candidate.unit).concise()
    low, high = candidate.plausible_range
    return (
        f"{candidate.effect} by itself would promise as much, but with {size}{unit}, where "
        f"{low:g} to {high:g}{unit} is believed."
    )


def _nothing(found: VerdictReport) -> str:
    """Say that nothing is missing, or, where more is left than noise, only that none was found."""
    used, chance = found.used, found.p_chi2
    if chance > RARE:
        return f"nothing is missing, as far as {used} shots can tell."
    return (
        f"no effect that {used} shots tell is missing, but chi-squared is "
        f"{found.chi2_per_dof:.3g} per degree of freedom, which noise of the stated size "
        f"exceeds with a chance of {chance:.2g}: the stated errors are too small, or something is "
        "missing that more shots would show."
    )


def _alike(found: VerdictReport) -> str:
    """Say what is sure, and of what is not which one of which."""
    sets = found.alias_sets
    sure = [name for name in found.effects if len(sets[name]) == 1]
    open_ = [f"one of {' or '.join(alike)}" for alike in sets.values() if len(alike) > 1]
    if not sure:
        verb = "are" if len(open_) > 1 else "is"
        return f"the missing effect{'s' * (len(open_) > 1)} {verb} {_listed(open_)}"
    return f"{_listed(sure)} {'are' if len(sure) > 1 else 'is'} missing, and {_listed(open_)}"


def _fall(found: VerdictReport) -> str:
    first, last = found.path[0], found.path[-1]
    it = "them" if len(found.effects) > 1 else "it"
    return (
        f"; with {it} the error on shots left out falls from {first.prediction_error:.3f} to "
        f"{last.prediction_error:.3f} of the noise{_each(found)}"
    )


def _each(found: VerdictReport) -> str:
    """Say where several effects leave the error, one after the other."""
    steps, before = [], set[str]()
    for stage in found.path[1:]:
        new = [name for name in stage.effects if name not in before]
        before = set(stage.effects)
        if len(new) == 1 and new[0] in found.effects:
            steps.append(f"{stage.prediction_error:.3f} with {new[0]}")
    return f" ({', '.join(steps)})" if len(steps) > 1 else ""


def _unexplained(found: VerdictReport) -> str:
    names = _listed(found.effects)
    verb = "explain" if len(found.effects) > 1 else "explains"
    part = f" {names} {verb} part of it." if names else ""
    if not found.structure:
        return (
            f"{found.campaign}: chi-squared is {found.chi2_per_dof:.3g} per degree of "
            f"freedom, where 1 is the noise, and no effect that {found.used} shots tell "
            f"explains it.{part} The stated errors are too small, or more shots are needed to see "
            "what is missing."
        )
    where = found.structure[0]
    missing = "something is missing that the catalogue does not hold"
    if found.used <= FEW:
        missing = f"no known effect explains all that these {found.used} shots show"
    return (
        f"{found.campaign}: {missing}.{part} "
        f"What is left shows most in {where.channel} against {where.covariate}"
        f"{_kind(where.channel)}."
    )


def _kind(channel: str) -> str:
    """Say of what kind structure of frames is; that of a contact says so itself."""
    if channel.startswith("image"):
        return ": the images, not the contact"
    if " position " in channel or " orientation " in channel:
        return ": the flight or the images, not the contact"
    return ""


def _listed(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
