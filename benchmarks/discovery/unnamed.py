"""Laws of the contact that no catalogue has: what is said of them, and what stands beside it.

Beside "unexplained" an effect has to lower the error on shots left out by more than two of its
sampling errors, and by a twentieth of what could be removed. Each is taken out here and fitted
again without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.evidence import stage_of
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import whole
from analysis.model.fitting.fit import fit_campaign
from analysis.model.verdict.selection import Verdict, explain
from benchmarks.discovery.campaigns import campaign
from benchmarks.discovery.goals import report, share
from benchmarks.discovery.lasting import PLAIN, lasting_campaign
from benchmarks.discovery.options import Options
from simulators.challenge.effects import HIDDEN
from simulators.challenge.unnamed import LAWS, Dependence

FIRST_SEED = 640_000
SAMPLINGS, SHARE, TRUE = 2.0, 0.05, "lasting-contact"


def run(options: Options) -> None:
    """Print the verdict on each law at full strength, in hard spheres and in lasting contacts."""
    unexplained, worth = list[bool](), list[bool]()
    for k, name in enumerate(LAWS):
        for world in ("hard", "lasting"):
            said = explain(_fired(world, name, FIRST_SEED + k, options.shots), CATALOGUE)
            # Of contacts that last the law of contact is in the verdict, and true.
            beside = [effect for effect in said.effects if effect != TRUE]
            falls, least = _falls(said, beside)
            unexplained.append(said.verdict == "unexplained")
            worth += [fall > least for fall in falls.values()]
            told = ", ".join(f"{one} {fall:.4f}" for one, fall in falls.items()) or "nothing"
            first, last = said.path[0].error.value, said.path[-1].error.value
            print(
                f"{world:8} {name:26} {said.verdict:12} error {first:.4f} to {last:.4f}; beside it "
                f"{told} (asked {least:.4f}); {said.cells[0].channel} with "
                f"{said.cells[0].covariate}",
                flush=True,
            )
    goals = [
        share("called unexplained", 0.9, unexplained),
        share("effects beside it that are worth their place", 1.0, worth),
    ]
    report("unnamed", goals, [])


def _fired(world: str, name: str, seed: int, shots: int) -> PoseData:
    amplitude = HIDDEN[name].amplitude
    if world == "hard":
        return campaign({name: amplitude}, seed, shots)
    nature = replace(PLAIN, dependence=Dependence(LAWS[name], amplitude))
    return lasting_campaign(nature, seed, shots)


def _falls(said: Verdict, beside: Sequence[str]) -> tuple[dict[str, float], float]:
    """Return by how much each effect lowers the error on shots left out, and what is asked."""
    data, last = whole(said.cleaned.data), said.path[-1]

    def without(names: Sequence[str]) -> float:
        theory = last.fit.theory
        for one in names:
            theory = theory.without_effect(one)
        return stage_of(data, fit_campaign(data, theory, last.fit)).error.value

    falls = {one: without([one]) - last.error.value for one in beside}
    base = without(beside) if beside else last.error.value
    return falls, max(SAMPLINGS * last.error.sampling, SHARE * (base - 1.0))
