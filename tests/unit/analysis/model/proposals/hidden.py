"""Campaigns of the simulated world, whose physics shares nothing with the analysis."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.gather import gather_poses
from analysis.model.data.poses import PoseData
from analysis.model.proposals.propose import propose
from analysis.model.proposals.proposed import Proposed
from simulators.challenge.campaign import run_campaign
from simulators.challenge.effects import switched
from simulators.challenge.folder import write_folder

SHOTS = 60


def campaign(amplitudes: Mapping[str, float], seed: int, shots: int = SHOTS) -> PoseData:
    """Return the poses of a campaign that hides these."""
    with TemporaryDirectory() as made:
        folder = Path(made) / "campaign"
        write_folder(folder, run_campaign(switched(amplitudes), seed, shots=shots))
        return gather_poses(folder)[1]


@cache
def proposed(name: str | None, amplitude: float = 0.0, seed: int = 3) -> tuple[PoseData, Proposed]:
    """Return a campaign and what is proposed for it."""
    data = campaign({} if name is None else {name: amplitude}, seed)
    return data, propose(data, (), CATALOGUE)
