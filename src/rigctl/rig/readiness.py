"""Being armed: who may begin it, the one live token, and every way in which it ends."""

from __future__ import annotations

from datetime import timedelta

from rigctl.config import Limits
from rigctl.errors import RefusedError, StoreError
from rigctl.rig.arming import Armed, ArmToken
from rigctl.rig.clock import Clock
from rigctl.rig.running import ACTOR
from rigctl.rig.standing import Standing
from rigctl.rig.states import LATCHED, RigState
from rigctl.settings import ShotSettings

_ARMABLE = frozenset({RigState.IDLE, RigState.ARMED})


class Readiness:
    """The token and the rig's state that goes with it; each method takes the rig's lock."""

    def __init__(self, standing: Standing, limits: Limits, clock: Clock) -> None:
        self._standing, self._clock = standing, clock
        self._lifetime_s = limits.arm_lifetime_s
        self._token = ArmToken(limits.arm_lifetime_s, clock.monotonic)

    def begin(self, settings: ShotSettings, actor: str) -> None:
        """Take a token back that lives, and say that the rig is being armed with these settings.

        Raises
        ------
        RefusedError
            The rig is in a state that does not arm.
        """
        with self._standing.lock:
            self.withdraw_expired()
            status = self._standing.status()
            if status.state not in _ARMABLE or status.running is not None:
                latched = status.state in LATCHED
                why = f" ({status.reason})" if latched else ""
                release = "look at it, then `rigctl release` it with a reason, the daemon running"
                raise RefusedError(
                    f"the rig is {status.state}{why} and cannot be armed",
                    todo=release if latched else "wait for the shot's end",
                    shot=status.running,
                )
            self.disarm(actor, "the rig is armed anew")
            self._standing.armed_for(settings)

    def give(self, settings: ShotSettings, actor: str) -> Armed:
        """Give a token; every interlock holds.

        Raises
        ------
        StoreError
            The audit cannot be written; the rig is idle.
        """
        with self._standing.lock:
            self._standing.move(RigState.CHECKED, actor, "every interlock holds")
            try:
                self._standing.move(RigState.ARMED, actor, "armed")
            except StoreError:
                self._standing.move(RigState.IDLE, ACTOR, "the audit cannot be written")
                raise
            expires_at = self._clock.wall() + timedelta(seconds=self._lifetime_s)
            ends_s = self._clock.monotonic() + self._lifetime_s
            self._standing.armed_for(settings, expires_at, ends_s)
            token = self._token.issue(settings)
            return Armed(token, expires_at, self._lifetime_s, self._standing.status().warnings)

    def take(self, token: str) -> ShotSettings:
        """Spend the token; as `ArmToken.take`."""
        with self._standing.lock:
            return self._token.take(token)

    def disarm(self, actor: str, reason: str) -> None:
        """Withdraw the live token, if there is one."""
        with self._standing.lock:
            self._token.withdraw(reason)
            if self._standing.state is RigState.ARMED:
                self._standing.move(RigState.IDLE, actor, reason)
                self._standing.armed_for(self._standing.status().settings)

    def stopped(self) -> None:
        """Kill the token at an emergency stop, which moves the rig by itself."""
        with self._standing.lock:
            self._token.withdraw("the emergency stop")

    def withdraw_expired(self) -> None:
        """Disarm where the token's time is over."""
        with self._standing.lock:
            if self._token.has_expired:
                self.disarm(ACTOR, f"the arm token expired after {self._lifetime_s:g} s")

    def look_for_expired(self) -> None:
        """As `withdraw_expired`, unless somebody else holds the rig's lock; waits for nothing."""
        if self._token.has_expired and self._standing.lock.acquire(blocking=False):
            try:
                self.withdraw_expired()
            finally:
                self._standing.lock.release()
