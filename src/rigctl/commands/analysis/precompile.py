"""`rigctl precompile`: compile the analysis for this machine; no first shot waits for it."""

from __future__ import annotations

import gc
import tempfile
from collections.abc import Callable
from pathlib import Path

from analysis.effects.catalogue import CATALOGUE
from analysis.model.verdict.selection import explain
from analysis.shot import AnalysisOptions, analyse_shot
from rigctl.commands.rig.simulated_campaign import fire_all, measurements, simulated
from rigctl.daemon import open_daemon
from rigctl.measuring.stored_shot import setup_of
from rigctl.model.campaigns import campaign_poses

CAMPAIGN = "precompile"
SWEEP = ((45.0, 3.0), (60.0, 9.0), (50.0, 12.0), (70.0, 6.0), (40.0, 1.0), (65.0, 14.0))
"""Pressure (kPa) and offset (mm): sticking and sliding contacts, so that both are compiled."""


def precompile(say: Callable[[str], None]) -> None:
    """Fire a small simulated campaign and do with it all that compiles.

    The photometric method is compiled by the process that measures the shots, the thesis's method
    and the model by this one meanwhile. What is compiled already takes seconds.

    Raises
    ------
    RigError
        The simulated rig refused, or there is no disk for its store.
    """
    # The compiler keeps nearly all that it makes: looking for garbage is a tenth of its time.
    gc.disable()
    with tempfile.TemporaryDirectory() as folder:
        configuration = simulated(Path(folder) / "store", "photometric", seed=1)
        with open_daemon(configuration) as daemon:
            names = fire_all(daemon, CAMPAIGN, SWEEP, say)
            say("compiling the method of edges")
            stored = daemon.store.folders
            frames = stored.frames(names[0])
            analyse_shot(
                frames.pixels,
                frames.times_s - frames.times_s[0],
                setup_of(stored.manifest(names[0])),
                AnalysisOptions(method="thesis"),
            )
            say("waiting for the photometric method, which is compiled beside it")
            measurements(daemon, names)
            say("compiling the model")
            explain(campaign_poses(daemon.store, CAMPAIGN)[1], CATALOGUE, say)
    gc.enable()
