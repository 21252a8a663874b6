"""What the photometric method has learned, shared by all analysing processes of a store.

A file for each campaign and set-up, `learned/<digest>.npz` beside the shots: a cache that may be
deleted at any time. Whether it still holds is not decided here: a shot that does not show the
learned spheres refuses them (`photometric.follow.confirmation`), and what is learned from it alone
takes their place.
"""

from __future__ import annotations

import hashlib
import json
import logging
import os
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from analysis.errors import InputError
from analysis.setup import Setup, without_exposure

if TYPE_CHECKING:
    from analysis.photometric.learn.appearance import Appearance

_log = logging.getLogger(__name__)

KEPT = 4
"""Pairs that a process holds in memory."""


class LearnedPairs:
    """Learned pairs in a folder, each read once by a process until another one has replaced it.

    For one thread of each process; processes may read and write at any time.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._held: dict[Path, tuple[int, Appearance]] = {}

    def recall(self, campaign: str | None, setup: Setup) -> Appearance | None:
        """Return what was learned of the pair of a campaign; None where nothing can be read."""
        path = self._path(campaign, setup)
        try:
            stamp = path.stat().st_mtime_ns
        except OSError:
            return None
        if path in self._held and self._held[path][0] == stamp:
            return self._held[path][1]
        # Loading compiled functions is slow.
        from analysis.photometric.learn.appearance import read_knowledge  # noqa: PLC0415

        try:
            known = read_knowledge(path)
        except InputError as error:
            _log.warning("learned anew: %s", error)
            return None
        self._hold(path, stamp, known)
        return known

    def remember(self, campaign: str | None, setup: Setup, known: Appearance) -> None:
        """Let all processes have what was learned; what was learned before is replaced as a whole.

        Raises
        ------
        OSError
            It cannot be written.
        """
        from analysis.photometric.learn.appearance import write_knowledge  # noqa: PLC0415

        path = self._path(campaign, setup)
        self._folder.mkdir(exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=self._folder, prefix=".", delete=False) as file:
            write_knowledge(file, known)
        os.replace(file.name, path)
        self._hold(path, path.stat().st_mtime_ns, known)

    def teachers(self, campaign: str | None, setup: Setup) -> tuple[str, ...]:
        """Return the shots that showed the pair so far, as many as it takes to learn it."""
        try:
            named = json.loads(self._path(campaign, setup).with_suffix(".json").read_bytes())
        except (OSError, ValueError):
            return ()
        return tuple(map(str, named))

    def keep_teachers(self, campaign: str | None, setup: Setup, shots: Sequence[str]) -> None:
        """Record for all processes which shots showed the pair.

        Raises
        ------
        OSError
            It cannot be written.
        """
        path = self._path(campaign, setup).with_suffix(".json")
        self._folder.mkdir(exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=self._folder, prefix=".", delete=False) as file:
            json.dump(list(shots), file)
        os.replace(file.name, path)

    def _hold(self, path: Path, stamp: int, known: Appearance) -> None:
        self._held.pop(path, None)
        if len(self._held) == KEPT:
            del self._held[next(iter(self._held))]
        self._held[path] = (stamp, known)

    def _path(self, campaign: str | None, setup: Setup) -> Path:
        """Return a pair's file; the exposure, which may change from shot to shot, has no part."""
        still = without_exposure(setup)
        text = json.dumps([campaign, asdict(still)], sort_keys=True)
        return self._folder / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.npz"
