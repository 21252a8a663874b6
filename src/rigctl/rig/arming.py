"""The arm token: one shot, one set of settings, a few seconds."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime

from rigctl.errors import ArmTokenError
from rigctl.settings import ShotSettings


@dataclass(frozen=True, slots=True)
class Armed:
    """The answer to an arm request.

    Attributes
    ----------
    token
        Fires once, these settings only.
    expires_at
        UTC, for people; the rig itself counts on the monotonic clock.
    expires_in_s
        Life of the token at the moment of arming.
    warnings
        What the operator must know about this apparatus before firing.
    """

    token: str
    expires_at: datetime
    expires_in_s: float
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _Live:
    token: str
    settings: ShotSettings
    expires: float


class ArmToken:
    """At most one live token. The rig's lock guards every call but `has_expired`.

    Parameters
    ----------
    lifetime_s
        Life of a token, s.
    monotonic
        The clock it lives on.
    """

    def __init__(self, lifetime_s: float, monotonic: Callable[[], float]) -> None:
        self._lifetime_s, self._monotonic = lifetime_s, monotonic
        self._live: _Live | None = None
        self._why_none = "the rig is not armed"

    def issue(self, settings: ShotSettings) -> str:
        """Return a fresh token bound to these settings; the one before is dead."""
        token = secrets.token_urlsafe(24)
        self._live = _Live(token, settings, self._monotonic() + self._lifetime_s)
        return token

    def take(self, token: str) -> ShotSettings:
        """Spend the token and return the settings it is bound to.

        Raises
        ------
        ArmTokenError
            It is unknown, spent, withdrawn or expired. A wrong token leaves the live one alive.
        """
        live = self._live
        if live is None or self.has_expired:
            why = self._why_none if live is None else f"it expired after {self._lifetime_s:g} s"
            raise _does_not_hold(why)
        if not hmac.compare_digest(live.token.encode(), token.encode()):
            raise _does_not_hold("another token is live")
        self.withdraw("it was spent on a shot")
        return live.settings

    def withdraw(self, why: str) -> None:
        """Kill the live token, if any; later attempts are told why."""
        if self._live is not None:
            self._live, self._why_none = None, why

    @property
    def has_expired(self) -> bool:
        """Whether a token is there whose time is over."""
        live = self._live
        return live is not None and self._monotonic() >= live.expires


def _does_not_hold(why: str) -> ArmTokenError:
    return ArmTokenError(
        f"the arm token does not hold: {why}",
        todo="arm again and fire with the token of that answer",
    )
