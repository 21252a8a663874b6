"""Every shot of a campaign that has frames, analysed by one method with common knowledge.

Wherever a shot is analysed, in this process or another, the same is done and sent back.
"""

from __future__ import annotations

import ctypes
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future
from dataclasses import dataclass
from functools import cache
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Self

from analysis.campaign import TEACHING_SHOTS
from analysis.setup import without_exposure
from rigctl.documents import Json
from rigctl.errors import NotFoundError, RigError
from rigctl.measuring.analysing import AnalysisFailedError
from rigctl.progress import Progress
from rigctl.reanalysis.pools import Pool
from rigctl.store import Change, ShotRecord, ShotState, Store
from rigctl.store.folders import result_text

if TYPE_CHECKING:
    from analysis.photometric.learn.appearance import Appearance


# The parameters' numbers in malloc.h.
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
LARGEST_KEPT = 32 << 20
"""Bytes of the largest array whose memory is kept: the limit to which the GNU C library adapts by
itself where none is set."""


@cache
def keep_memory() -> None:
    """Keep the memory of arrays for the next ones, up to 64 MiB of it in this process.

    It is a matter of time alone. Where the C library is not GNU's, nothing is done.
    """
    library = ctypes.CDLL(None)
    # As elsewhere in that library: what is free at the end of the heap may be twice as much.
    for parameter, size in ((_MMAP_THRESHOLD, LARGEST_KEPT), (_TRIM_THRESHOLD, 2 * LARGEST_KEPT)):
        if hasattr(library, "mallopt"):
            library.mallopt(parameter, size)


LONG = frozenset({"poses", "overlay"})
"""Bulky fields of a result that the storing process does not need."""


@dataclass(frozen=True, slots=True)
class Found:
    """What an analysis found.

    Attributes
    ----------
    text
        The result as its file is to have it: to make it takes longer than to store it, and those
        who analyse are many.
    brief
        The result without what is `LONG`.
    """

    text: bytes
    brief: Json

    @classmethod
    def of(cls, result: Json) -> Self:
        """Return a result in this form; raise `ValueError` for a number that is not finite."""
        brief = {name: value for name, value in result.items() if name not in LONG}
        return cls(result_text(result), brief)


@dataclass(frozen=True, slots=True)
class Broken:
    """Why the analysis of a shot came to nothing, in words that any process understands."""

    why: str

    @classmethod
    def of(cls, error: Exception) -> Self:
        """Return the words of an error."""
        if isinstance(error, RigError):
            return cls(error.sentence())
        return cls(f"{type(error).__name__}: {error}")


def analysed(
    folders: Sequence[Path], method: str, known: Appearance | None
) -> list[Found | Broken]:
    """Analyse shots one after another; one that breaks stops no other."""
    # Loaded only by the process that analyses.
    from rigctl.measuring.stored_shot import analyse_stored_shot_with  # noqa: PLC0415

    keep_memory()
    found: list[Found | Broken] = []
    for folder in folders:
        try:
            found.append(Found.of(analyse_stored_shot_with(folder, method, known)))
        except Exception as error:  # noqa: BLE001 - whatever breaks is this shot's failure alone
            found.append(Broken.of(error))
    return found


def taught(folders: Sequence[Path]) -> Appearance | None:
    """Return what shots teach of their spheres; those that cannot do not."""
    from analysis.photometric.teaching import teach  # noqa: PLC0415
    from rigctl.measuring.stored_shot import read_stored_shot  # noqa: PLC0415

    keep_memory()
    read = [read_stored_shot(folder) for folder in folders]
    setup = without_exposure(read[0][2])
    return teach([shot for shot in read if without_exposure(shot[2]) == setup])


FREE = frozenset({ShotState.STORED, ShotState.ANALYSED, ShotState.REFUSED})
"""States in which no other process is about to write a result."""


Placed = tuple[int, ShotRecord]
"""A shot, with its place in the order of firing, from 1."""

Task = tuple[list[Placed], Future[list[Found | Broken]]]
"""Shots that one worker was given together, and what comes of each."""

Submit = Callable[[Sequence[Placed]], Future[list[Found | Broken]]]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one shot.

    Attributes
    ----------
    shot
        Its present record.
    before, after
        Its latest result before, and the one that was added, this one without its poses and what
        to draw; None: there is none.
    failure
        Why nothing was added; None where something was.
    """

    shot: ShotRecord
    before: Json | None
    after: Json | None
    failure: str | None = None


def reanalyse_campaign(
    store: Store, campaign: str, method: str, pool: Pool, progress: Progress
) -> Iterator[Outcome]:
    """Analyse every shot with frames once more; results are added, none is replaced.

    The photometric method learns the spheres from the first shots and measures all with the same
    knowledge: results depend on neither the order nor the place of the work. A shot that breaks,
    whose process dies, or that a daemon is analysing, keeps what it has; the others go on.

    The work is done while the outcomes are taken. Few shots are under way at any time, and each
    result is on disk before its outcome is given: memory does not grow with the campaign.

    Returns
    -------
    In the order of firing, what came of each shot that was there at the call.

    Raises
    ------
    NotFoundError
        There is no such campaign, or none of its shots has frames.
    AnalysisFailedError
        The process died in which the spheres are learned.
    StoreError
        The catalogue cannot record that a shot was analysed.
    """
    total = store.campaigns.one(campaign).shots
    there = enumerate(islice(store.catalogue.each(campaign), total), start=1)
    shots = ((place, shot) for place, shot in there if shot.frames and shot.state in FREE)
    first = list(islice(shots, TEACHING_SHOTS))
    if not first:
        raise NotFoundError(
            "no shot has frames that nobody is analysing",
            part=f"campaign {campaign}",
            todo="await the analysis that is under way",
        )
    progress("learning the spheres", 0.0)
    known = None
    if method == "photometric":
        teaching = [store.folders.folder(shot.id) for _, shot in first]
        try:
            known = pool.executor.submit(taught, teaching).result()
        except BrokenExecutor as error:
            part = f"campaign {campaign}"
            raise AnalysisFailedError(f"no sphere was learned: {error}", part=part) from error

    def submit(batch: Sequence[Placed]) -> Future[list[Found | Broken]]:
        folders = [store.folders.folder(shot.id) for _, shot in batch]
        return pool.executor.submit(analysed, folders, method, known)

    tasks = _under_way(chain(first, shots), total, submit, pool)
    return _outcomes(store, tasks, lambda shot, place: progress(f"shot {shot}", place / total))


def _under_way(shots: Iterator[Placed], total: int, submit: Submit, pool: Pool) -> Iterator[Task]:
    """Give tasks in order, few of them ahead of what is stored."""
    waiting = deque[Task]()
    left = total
    while True:
        while len(waiting) < pool.ahead and (batch := list(islice(shots, pool.share(left)))):
            # Shots without frames are no part of any task, but of the total.
            left = total - batch[-1][0]
            waiting.append((batch, submit(batch)))
        if not waiting:
            return
        yield waiting.popleft()


def _outcomes(
    store: Store, tasks: Iterator[Task], done: Callable[[str, int], None]
) -> Iterator[Outcome]:
    for batch, future in tasks:
        found: list[Found | Broken] = _found(future, len(batch))
        # A future holds its results, which would be held until the next is done.
        del future
        for place, shot in batch:
            outcome = _kept(store, shot, found.pop(0))
            done(shot.id, place)
            yield outcome
            del outcome


def _found(future: Future[list[Found | Broken]], count: int) -> list[Found | Broken]:
    """Return what came of the shots of a task; the same of all where the task itself broke."""
    try:
        return list(future.result())
    except Exception as error:  # noqa: BLE001 - whatever breaks is the failure of these shots alone
        return [Broken.of(error)] * count


def _kept(store: Store, shot: ShotRecord, result: Found | Broken) -> Outcome:
    """Store what came of a shot beside what there was."""
    before: Json | None = None
    try:
        before = store.folders.result(shot.id, shot.results) if shot.results else None
    except RigError as error:
        return Outcome(shot, before, None, error.sentence())
    if isinstance(result, Broken):
        return Outcome(shot, before, None, result.why)
    try:
        store.move(shot.id, ShotState.ANALYSING)
    except RigError as error:
        return Outcome(store.shot(shot.id), before, None, error.sentence())
    try:
        number = store.folders.add_result(shot.id, result.text)
    except RigError as error:
        as_before = Change(failure=shot.failure, failure_code=shot.failure_code)
        record = store.move(shot.id, shot.state, as_before)
        return Outcome(record, before, None, error.sentence())
    brief = result.brief
    if brief["status"] == "refused":
        change = Change(results=number, failure=str(brief["reason"]), failure_code="refused")
        return Outcome(store.move(shot.id, ShotState.REFUSED, change), before, brief)
    change = Change(results=number)
    return Outcome(store.move(shot.id, ShotState.ANALYSED, change), before, brief)
