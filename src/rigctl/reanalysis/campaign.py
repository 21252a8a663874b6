"""Every shot of a campaign that has frames, analysed by one method with common knowledge."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rigctl.analysis_process import AnalysisFailedError
from rigctl.errors import NotFoundError, RigError
from rigctl.reanalysis.pools import Pool
from rigctl.store import Change, ShotRecord, ShotState, Store

if TYPE_CHECKING:
    from analysis.photometric.appearance import Knowledge

Json = dict[str, Any]
Say = Callable[[str, float | None], None]
Submit = Callable[[ShotRecord], Future[Json]]

TEACHING_SHOTS = 3
"""Shots from which the photometric method learns the spheres before it measures any."""

FREE = frozenset({ShotState.STORED, ShotState.ANALYSED, ShotState.REFUSED})
"""States in which nobody else is about to write a result."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one shot.

    Attributes
    ----------
    shot
        As it stands now.
    before, after
        Its latest result before, and the one that was added; None: there is none.
    failure
        Why nothing was added; None where something was.
    """

    shot: ShotRecord
    before: Json | None
    after: Json | None
    failure: str | None = None


def reanalyse_campaign(
    store: Store, campaign: str, method: str, pool: Pool, say: Say
) -> Iterator[Outcome]:
    """Analyse every shot with frames once more; results are added, none is replaced.

    The photometric method learns the spheres from the first shots and measures all with the same
    knowledge: results depend on neither the order nor the place of the work. A shot that breaks,
    or that a daemon is analysing, keeps what it has; the others go on.

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
        Later, as outcomes are taken: a process that analyses died, and with it the pool.
    StoreError
        Likewise: the catalogue does not take that a shot was analysed.
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
    say("learning the spheres", 0.0)
    known = None
    if method == "photometric":
        teaching = [store.folders.folder(shot.id) for _, shot in first]
        known = pool.executor.submit(taught, teaching).result()

    def submit(shot: ShotRecord) -> Future[Json]:
        try:
            return pool.executor.submit(analysed, store.folders.folder(shot.id), method, known)
        except BrokenExecutor as error:
            raise AnalysisFailedError(
                f"a process that analyses died: {error}",
                part=f"campaign {campaign}",
                todo="look at the host's memory, then analyse it again; what was added stays",
                shot=shot.id,
            ) from error

    futures = _under_way(chain(first, shots), submit, pool)
    return _outcomes(store, futures, lambda shot, place: say(f"shot {shot}", place / total))


def analysed(folder: Path, method: str, known: Knowledge | None) -> Json:
    """Analyse one shot, wherever this runs."""
    # Loaded by the process that analyses: the others have no use for it.
    from rigctl.stored_shot import analyse_stored_shot_as_taught  # noqa: PLC0415

    return analyse_stored_shot_as_taught(folder, method, known)


def taught(folders: Sequence[Path]) -> Knowledge | None:
    """Return what shots teach of their spheres, wherever this runs; those that cannot do not."""
    from analysis.photometric.method import teach  # noqa: PLC0415
    from rigctl.stored_shot import read_stored_shot  # noqa: PLC0415

    read = [read_stored_shot(folder) for folder in folders]
    setup = read[0][2]
    return teach([(frames, times_s) for frames, times_s, own in read if own == setup], setup)


def _under_way(
    shots: Iterator[tuple[int, ShotRecord]], submit: Submit, pool: Pool
) -> Iterator[tuple[int, ShotRecord, Future[Json]]]:
    """Give shots with their places and the futures of their results, few of them ahead."""
    waiting = deque[tuple[int, ShotRecord, Future[Json]]]()
    while True:
        try:
            for place, shot in islice(shots, max(pool.ahead - len(waiting), 0)):
                waiting.append((place, shot, submit(shot)))
        except AnalysisFailedError:
            # What was done before the pool died is not to be lost with it.
            yield from waiting
            raise
        if not waiting:
            return
        yield waiting.popleft()


def _outcomes(
    store: Store,
    under_way: Iterator[tuple[int, ShotRecord, Future[Json]]],
    done: Callable[[str, int], None],
) -> Iterator[Outcome]:
    for place, shot, future in under_way:
        outcome = _kept(store, shot, future)
        # A future holds its result, which would be held until the next is done.
        del future
        done(shot.id, place)
        yield outcome
        del outcome


def _kept(store: Store, shot: ShotRecord, future: Future[Json]) -> Outcome:
    """Store what came of a shot beside what there was."""
    before: Json | None = None
    try:
        before = store.folders.result(shot.id, shot.results) if shot.results else None
        result = future.result()
    except RigError as error:
        return Outcome(shot, before, None, error.sentence())
    except Exception as error:  # noqa: BLE001 - whatever breaks is this shot's failure alone
        return Outcome(shot, before, None, f"{type(error).__name__}: {error}")
    try:
        store.move(shot.id, ShotState.ANALYSING)
    except RigError as error:
        return Outcome(store.shot(shot.id), before, None, error.sentence())
    try:
        number = store.folders.add_result(shot.id, result)
    except RigError as error:
        as_before = Change(failure=shot.failure, failure_code=shot.failure_code)
        record = store.move(shot.id, shot.state, as_before)
        return Outcome(record, before, None, error.sentence())
    if result["status"] == "refused":
        change = Change(results=number, failure=str(result["reason"]), failure_code="refused")
        return Outcome(store.move(shot.id, ShotState.REFUSED, change), before, result)
    change = Change(results=number)
    return Outcome(store.move(shot.id, ShotState.ANALYSED, change), before, result)
