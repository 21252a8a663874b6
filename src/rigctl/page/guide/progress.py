"""How far the first visit has come: which of its four steps is the next, read from the store."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rigctl.store import CampaignRecord, ShotState

ENOUGH = 20
"""So many measured shots of one campaign are compared with the model; fewer seldom tell anything.
Of the thirty that the guide has fired some may be refused."""
STEPS = (
    ("Fire a shot", "about 10 s"),
    ("Read what was measured", "bounce, sliding, spin"),
    ("Let it fire 30 more", "by itself, some minutes"),
    ("Find what the model misses", "watch the error fall"),
)
FIRE, READ, SWEEP, COMPARE = range(1, len(STEPS) + 1)
OVER = len(STEPS) + 1


@dataclass(frozen=True, slots=True)
class Progress:
    """Where the visit stands.

    Attributes
    ----------
    step
        The next step, 1 to 4; 5 when all are done.
    campaign
        The campaign of the store with most measured shots; empty while there is none.
    measured, fired
        Its measured shots, and all of them.
    """

    step: int
    campaign: str = ""
    measured: int = 0
    fired: int = 0


def progress_of(
    campaigns: Sequence[CampaignRecord], *, any_measured: bool, compared: bool
) -> Progress:
    """Return where the visit stands.

    Parameters
    ----------
    campaigns
        Of the store.
    any_measured
        Whether any shot is measured, of a campaign or of none.
    compared
        Whether a campaign stands beside its model on this page.
    """
    if compared:
        return Progress(OVER)
    counted = [(one.states.get(ShotState.ANALYSED, 0), one) for one in campaigns]
    measured, best = max(counted, key=lambda pair: pair[0], default=(0, None))
    if best is None:
        return Progress(READ if any_measured else FIRE)
    if measured >= ENOUGH:
        step = COMPARE
    elif best.shots > 1:
        step = SWEEP
    else:
        step = READ if any_measured else FIRE
    return Progress(step, best.name, measured, best.shots)
