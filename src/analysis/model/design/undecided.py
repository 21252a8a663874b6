"""What to fire after a verdict that leaves several effects to choose from."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from analysis.effects.effect import Effect, ScatterEffect
from analysis.errors import LaunchRefusedError
from analysis.launch.fit import fit_launch
from analysis.launch.prediction import Limits
from analysis.launch.settings import OFFSET, PRESSURES
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import CampaignData, whole
from analysis.model.design.between import Telling, tell_apart
from analysis.model.design.candidates import grid
from analysis.model.design.misfit import MisfitError
from analysis.model.fitting.fit import fit_campaign
from analysis.model.verdict.selection import Verdict, explain


def explain_with_next(
    data: CampaignData, effects: Sequence[Effect], report: Callable[[str], None]
) -> tuple[Verdict, Telling | None]:
    """Come to a verdict, and choose the shots that would end its doubts."""
    verdict = explain(data, effects, report)
    report("choosing shots")
    return verdict, next_after(verdict, effects)


def next_after(
    verdict: Verdict, effects: Sequence[Effect], limits: Limits | None = None
) -> Telling | None:
    """Return the shots that tell apart what a verdict leaves open.

    Of its effects the first that has company is held against each other one; the answer is the
    pair that needs most shots. None where there is nothing to tell apart, the settings of the
    campaign do not let shots be foretold, neither effect fits alone, or it holds no poses.

    Parameters
    ----------
    effects
        Those that the verdict chose from.
    limits
        What the rig allows; None: what the campaign has used.
    """
    alike = next((alike for alike in verdict.alias_sets.values() if len(alike) > 1), ())
    names = [n for n in alike if not isinstance(_named(effects, n), ScatterEffect)]
    if verdict.verdict != "alias" or len(names) < 2:
        return None
    data, theory = whole(verdict.cleaned.data), verdict.fit.theory
    if not isinstance(data, PoseData):
        return None
    for active in theory.active:
        if active.effect.name in names:
            theory = theory.without_effect(active.effect.name)
    base = fit_campaign(data, theory, verdict.fit)
    try:
        launch = fit_launch(data, verdict.fit)
        settings = grid(limits or used_limits(data), alike=fired_alike(data))
        told = [
            tell_apart(
                data, base, launch, (_named(effects, names[0]), _named(effects, other)), settings
            )
            for other in names[1:]
        ]
    except (LaunchRefusedError, MisfitError):
        return None
    return max(told, key=lambda one: (not one.enough, one.count))


def used_limits(data: PoseData) -> Limits:
    """Return the range of a campaign's own settings.

    Raises
    ------
    LaunchRefusedError
        Pressures or offsets are not known of all shots.
    """
    known = data.covariates
    if missing := [name for name in (*PRESSURES, OFFSET) if name not in known]:
        raise LaunchRefusedError(f"settings that not all shots have: {', '.join(missing)}")
    pressures = np.concatenate([known[name] for name in PRESSURES])
    return Limits(
        (float(pressures.min()), float(pressures.max())),
        (float(known[OFFSET].min()), float(known[OFFSET].max())),
    )


def fired_alike(data: PoseData) -> bool:
    """Return whether both pushers had the same pressure in every shot."""
    a, b = (data.covariates.get(name, np.zeros(len(data.shots))) for name in PRESSURES)
    return bool(np.array_equal(a, b))


def _named(effects: Sequence[Effect], name: str) -> Effect:
    return next(effect for effect in effects if effect.name == name)
