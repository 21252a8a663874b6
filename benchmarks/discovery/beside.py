"""What verdicts name beside a contact that lasts, where the world has nothing else.

Poses err as is stated of films (`filmed_errors`), slowly by --slow-px, while half and twice as much
are stated in turn; the drag of the air is drawn from what is stated of it. What all flights share
is the same all over the field in one half of the campaigns, and changes with the place in the
other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.poses import PoseData
from analysis.model.verdict.selection import Verdict, explain
from benchmarks.discovery.filmed_errors import filmed
from benchmarks.discovery.goals import Goal, report, share
from benchmarks.discovery.hidden import MISSTATED, SLOW_PX
from benchmarks.discovery.lasting import PLAIN, STATED_DRAG
from benchmarks.discovery.options import Options

FIRST_SEED = 970_000
LAW = "lasting-contact"
STATED_ERROR = 0.2
KINDS = {"all over the field alike": False, "by place": True}


def run(options: Options) -> None:
    """Print how often more is named than the contact, and how often it is not named at all."""
    found: dict[str, list[Verdict]] = {kind: [] for kind in KINDS}
    for seed in range(FIRST_SEED, FIRST_SEED + options.campaigns):
        for kind, by_place in KINDS.items():
            data = campaign_with(seed, options, by_place=by_place)
            found[kind].append(explain(data, CATALOGUE))
            _tell(kind, seed, found[kind][-1])
    report("beside", [goal for kind, own in found.items() for goal in _goals(kind, own)], [])


def _goals(kind: str, found: Sequence[Verdict]) -> list[Goal]:
    more = [bool({*one.effects} - {LAW}) for one in found]
    unseen = [LAW not in one.effects for one in found]
    unexplained = [one.verdict == "unexplained" for one in found]
    return [
        share(f"shared errors {kind}: more named", 0.05, more, at_least=False),
        share(f"shared errors {kind}: contact not named", 0.01, unseen, at_least=False),
        share(f"shared errors {kind}: unexplained", 0.01, unexplained, at_least=False),
    ]


def campaign_with(seed: int, options: Options, *, by_place: bool) -> PoseData:
    """Return poses of the rig's own contact, their slow errors stated too small or too large."""
    drag = np.random.default_rng(seed).normal(STATED_DRAG, STATED_ERROR)
    nature = replace(PLAIN, drag_coefficient=max(float(drag), 0.0))
    slow_px = SLOW_PX if options.slow_px is None else options.slow_px
    data = filmed(nature, seed, options.shots, slow_px, by_place=by_place)
    wrong = MISSTATED[seed % len(MISSTATED)]
    slow = replace(
        data.slow,
        position_m=wrong * data.slow.position_m,
        rotation_rad=wrong * data.slow.rotation_rad,
    )
    return replace(data, slow=slow, drag_coefficient=STATED_DRAG)


def _tell(kind: str, seed: int, verdict: Verdict) -> None:
    """Print a verdict in a line, with the sizes of what is named beside the contact."""
    fit, cell = verdict.fit, verdict.cells[0]
    sizes = ", ".join(
        f"{name} {one.value:.3g}({one.sigma:.1g})"
        for name, one in fit.parameters().items()
        if "." in name and not name.startswith(LAW)
    )
    print(
        f"  {kind}, {seed}: {verdict.verdict} {', '.join(verdict.effects)} {sizes}; chi2"
        f" {fit.chi2_per_dof:.3f}, left out {verdict.path[-1].error.value:.4f};"
        f" {cell.channel} | {cell.covariate} p {cell.p_holm:.2g}",
        flush=True,
    )
