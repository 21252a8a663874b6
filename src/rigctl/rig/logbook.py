"""Writes every transition into the audit, and owes it what could not be written."""

from __future__ import annotations

import logging

from rigctl.errors import StoreError
from rigctl.rig.states import TOWARD_FIRE
from rigctl.rig.status import Transition
from rigctl.store.journal import Journal

_log = logging.getLogger(__name__)


class Logbook:
    """The rig's side of the audit. The rig's lock guards every call.

    A step toward firing is not taken unless it is on disk. A step toward safety is taken in any
    case; what the disk refuses of it is written later, in order, before anything else.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._owed: list[Transition] = []

    def write(self, transition: Transition) -> None:
        """Append a transition.

        Raises
        ------
        StoreError
            The audit cannot be written and the step leads toward firing.
        """
        owed = [*self._owed, transition]
        try:
            while owed:
                self._append(owed[0])
                del owed[0]
        except StoreError:
            if transition.after in TOWARD_FIRE:
                self._owed = owed[:-1]
                raise
            _log.exception("transition to %s is owed to the audit", transition.after)
        self._owed = owed

    def _append(self, transition: Transition) -> None:
        self._journal.append(
            at=transition.at,
            before=transition.before,
            after=transition.after,
            actor=transition.actor,
            reason=transition.reason,
            shot=transition.shot,
        )
