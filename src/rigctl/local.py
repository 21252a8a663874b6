"""A rig inside this process, for one shot without a daemon."""

from __future__ import annotations

import getpass
import time
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from analysis.arrays import Floats, Grey
from rigctl.config import load
from rigctl.daemon import Daemon, open_daemon
from rigctl.errors import RefusedError
from rigctl.measuring.stored_shot import read_stored_shot
from rigctl.rig.arming import Armed
from rigctl.service.models import ShotOrder, ShotView
from rigctl.settings import ShotSettings


class LocalRig:
    """The rig of a daemon that lives in this process, called without REST."""

    def __init__(self, daemon: Daemon, actor: str) -> None:
        self._daemon, self._actor = daemon, actor

    def arm(self, settings: ShotSettings) -> Armed:
        """Set the rig, wait until it has settled, and return token and warnings."""
        return self._daemon.rig.arm(settings, self._actor)

    def fire(self, token: str, key: str, campaign: str | None) -> str:
        """Fire once under this idempotency key and return the shot's id."""
        order = ShotOrder(arm_token=token, campaign=campaign)
        record = self._daemon.rig.accept(
            token=token,
            key=key,
            body_hash=order.digest(),
            campaign=order.campaign,
            note=None,
            actor=self._actor,
        )
        return record.id

    def shot(self, shot: str) -> Mapping[str, Any]:
        """Return one shot as the service would list it."""
        return ShotView.of(self._daemon.store.shot(shot)).model_dump(mode="json")

    def filmed(self, settings: ShotSettings) -> tuple[Grey, Floats]:
        """Fire one shot and return its frames and their times from the first, s, once stored.

        Raises
        ------
        RefusedError
            The shot came to no frames.
        RigError
            As `arm` and `fire`.
        """
        shot = self._daemon.rig.wait(self.fire(self.arm(settings).token, str(uuid.uuid4()), None))
        if shot.is_without_frames:
            raise RefusedError(
                f"the shot ended as {shot.state}: {shot.failure}",
                shot=shot.id,
                todo="look at the rig before the next one",
            )
        frames, times_s, _ = read_stored_shot(self._daemon.store.folders.folder(shot.id))
        return frames, times_s

    def compiling(self) -> str | None:
        """Return how far the compiler is that an analysis waits for; None: none does."""
        now = self._daemon.compiling()
        if now is None:
            return None
        left = now.left_s(time.monotonic())
        words = "" if left is None else f", about {max(1, round(left / 60))} min left"
        return f"compiling for this computer, once: {now.words}, {100 * now.share:.0f} %{words}"

    def result(self, shot: str) -> Mapping[str, Any]:
        """Return the measurement of one shot."""
        return self._daemon.store.result(shot)


@contextmanager
def opened(path: Path | None) -> Iterator[LocalRig]:
    """Open the rig of a configuration; leave it safe and closed whatever happens.

    Raises
    ------
    ConfigurationError
        The configuration cannot be.
    StoreError
        A daemon already runs on its store.
    """
    with open_daemon(load(path)) as daemon:
        yield LocalRig(daemon, f"{getpass.getuser()} on the command line")
