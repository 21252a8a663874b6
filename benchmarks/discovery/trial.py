"""One campaign put to the test, and many of them in processes of their own."""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.evidence import stage_of
from analysis.model.data.inside import without_contact_frames
from analysis.model.fitting.fit import fit_campaign
from analysis.model.verdict.selection import Verdict, explain
from benchmarks.discovery.campaigns import campaign
from benchmarks.discovery.filming import filmed_campaign
from benchmarks.discovery.strength import amplitude_at
from benchmarks.discovery.treatments import TREATMENTS
from simulators.challenge.effects import HIDDEN


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A campaign to be judged.

    Attributes
    ----------
    amplitudes
        Of what it hides, in the effects' own units.
    wanted
        Or d of each effect that it hides, from which amplitudes are found.
    treatment
        What was done to its data.
    with_floor
        Whether the error is wanted that the same campaign has with nothing hidden.
    filmed
        Whether it is rendered and its poses are measured from the frames.
    """

    seed: int
    shots: int
    amplitudes: Mapping[str, float] = field(default_factory=dict)
    wanted: Mapping[str, float] = field(default_factory=dict)
    treatment: str = "as stated"
    one_setting: bool = False
    with_floor: bool = False
    filmed: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """What was hidden and what was said.

    Attributes
    ----------
    errors
        Mean squared whitened error on shots left out (E_cv), along the path.
    floor
        The same of the campaign with nothing hidden; NaN where it was not wanted.
    cell
        The most striking cell: channel, covariate, chi-squared, p with all looked at.
    strength
        d of all that is hidden, in the noise that was measured; NaN where it was not wanted.
    """

    task: Task
    amplitudes: Mapping[str, float]
    word: str
    effects: tuple[str, ...]
    alias_set: tuple[str, ...]
    errors: tuple[float, ...]
    floor: float
    chi2_per_dof: tuple[float, ...]
    cell: tuple[str, str, float, float]
    dropped: int
    seconds: float
    strength: float = float("nan")

    @property
    def named(self) -> set[str]:
        """Every name that the verdict gives."""
        return {*self.effects, *self.alias_set}

    @property
    def claimed(self) -> bool:
        """Whether an effect is said to be there."""
        return self.word in {"effect", "alias"}

    def holds(self, name: str) -> bool:
        """Return whether an effect, or one that contains it, is named."""
        return bool({name, *HIDDEN[name].beside} & self.named)


def judge(task: Task) -> Trial:
    """Make a campaign and have it explained."""
    amplitudes = dict(task.amplitudes)
    for name, d in task.wanted.items():
        amplitudes[name] = amplitude_at(name, d, task.seed, task.shots)
    if task.filmed:
        data, d = filmed_campaign(amplitudes, task.seed, task.shots)
    else:
        data, d = campaign(amplitudes, task.seed, task.shots, one_setting=task.one_setting), np.nan
    data = TREATMENTS[task.treatment](data, np.random.default_rng([task.seed, 7]))
    start = time.process_time()
    verdict = explain(data, CATALOGUE)
    trial = _trial(task, amplitudes, verdict, time.process_time() - start)
    return replace(trial, strength=d)


def _trial(task: Task, amplitudes: Mapping[str, float], verdict: Verdict, seconds: float) -> Trial:
    cell = verdict.cells[0]
    return Trial(
        task=task,
        amplitudes=amplitudes,
        word=verdict.verdict,
        effects=verdict.effects,
        alias_set=verdict.alias_set,
        errors=tuple(stage.error.value**2 for stage in verdict.path),
        floor=_floor(task) if task.with_floor else float("nan"),
        chi2_per_dof=tuple(stage.fit.chi2_per_dof for stage in verdict.path),
        cell=(cell.channel, cell.covariate, cell.chi2, cell.p_holm),
        dropped=int((~verdict.cleaned.kept).sum()),
        seconds=seconds,
    )


def _floor(task: Task) -> float:
    quiet = without_contact_frames(campaign({}, task.seed, task.shots))
    return stage_of(quiet, fit_campaign(quiet)).error.value ** 2


def judged(tasks: Sequence[Task], processes: int) -> list[Trial]:
    """Judge campaigns, each process with one thread."""
    # Read when a process loads its linear algebra, so set before the first is started.
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ[name] = "1"
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=fresh) as pool:
        return list(pool.map(judge, tasks, chunksize=4))
