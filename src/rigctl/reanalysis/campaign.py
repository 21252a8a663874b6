"""Every shot of a campaign that has frames, analysed by one method with common knowledge."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rigctl.errors import NotFoundError, RigError
from rigctl.store import Change, ShotRecord, ShotState, Store

if TYPE_CHECKING:
    from analysis.photometric.appearance import Knowledge

Json = dict[str, Any]
Say = Callable[[str, float | None], None]

TEACHING_SHOTS = 3
"""Shots from which the photometric method learns the spheres before it measures any."""

FREE = frozenset({ShotState.STORED, ShotState.ANALYSED, ShotState.REFUSED})
"""States in which nobody else is about to write a result."""

_ALL = 10_000_000


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
    store: Store, campaign: str, method: str, executor: Executor, say: Say
) -> list[Outcome]:
    """Analyse every shot with frames once more; results are added, none is replaced.

    The photometric method learns the spheres from the first shots and measures all with the same
    knowledge: results depend on neither the order nor the place of the work. A shot that breaks,
    or that a daemon is analysing, keeps what it has; the others go on.

    Returns
    -------
    In the order of firing, what came of each.

    Raises
    ------
    NotFoundError
        There is no such campaign, or none of its shots has frames.
    """
    store.campaigns.one(campaign)
    shots = [s for s in store.shots(campaign=campaign, limit=_ALL) if s.frames and s.state in FREE]
    if not shots:
        raise NotFoundError(
            "no shot has frames that nobody is analysing",
            part=f"campaign {campaign}",
            todo="await the analysis that is under way",
        )
    folders = {shot.id: store.folders.folder(shot.id) for shot in shots}
    say("learning the spheres", 0.0)
    known = None
    if method == "photometric":
        teaching = list(folders.values())[:TEACHING_SHOTS]
        known = executor.submit(taught, teaching).result()
    waiting: dict[Future[Json], ShotRecord] = {
        executor.submit(analysed, folders[shot.id], method, known): shot for shot in shots
    }
    outcomes: dict[str, Outcome] = {}
    for future in as_completed(waiting):
        shot = waiting[future]
        outcomes[shot.id] = _kept(store, shot, future)
        say(f"analysed shot {shot.id}", len(outcomes) / len(shots))
    return [outcomes[shot.id] for shot in shots]


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


def _kept(store: Store, shot: ShotRecord, future: Future[Json]) -> Outcome:
    """Store what came of a shot beside what there was."""
    before = store.folders.result(shot.id, shot.results) if shot.results else None
    try:
        result = future.result()
    except Exception as error:  # noqa: BLE001 - whatever breaks is this shot's failure alone
        return Outcome(shot, before, None, f"{type(error).__name__}: {error}")
    try:
        store.move(shot.id, ShotState.ANALYSING)
        number = store.folders.add_result(shot.id, result)
        if result["status"] == "refused":
            change = Change(results=number, failure=str(result["reason"]), failure_code="refused")
            record = store.move(shot.id, ShotState.REFUSED, change)
        else:
            record = store.move(shot.id, ShotState.ANALYSED, Change(results=number))
    except RigError as error:
        return Outcome(store.shot(shot.id), before, None, error.sentence())
    return Outcome(record, before, result)
