"""Campaigns of the simulators as frames: rendered, measured, and what their noise lets show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.spatial.transform import Rotation

from analysis.model.data.gather import gather_poses
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import fit_campaign
from benchmarks.discovery.campaigns import SILENCE
from simulators.challenge.camera import OPTICS
from simulators.challenge.campaign import FRAME_RATE_HZ, Fired, fire, measure
from simulators.challenge.effects import switched
from simulators.challenge.folder import write_frames
from simulators.challenge.launch import FILMED_PRESSURES_KPA
from simulators.challenge.pictures import filmed


def filmed_campaign(
    amplitudes: Mapping[str, float], seed: int, shots: int
) -> tuple[PoseData, float]:
    """Render and measure a campaign; return its poses, and d of what it hides.

    d is the root of the chi-squared that the base model leaves of the true poses, in the noise that
    the measurement states.
    """
    nature = switched(amplitudes)
    fired = fire(nature, seed, shots=shots, pressures_kpa=FILMED_PRESSURES_KPA)
    with TemporaryDirectory() as made:
        folder = Path(made) / "campaign"
        write_frames(folder, fired.settings, filmed(fired, nature, OPTICS, seed))
        _, data = gather_poses(folder)
    if not amplitudes:
        return data, 0.0
    true = without_contact_frames(_true(data, fired, amplitudes, seed))
    return data, float(np.sqrt(fit_campaign(true).chi2))


def _true(data: PoseData, fired: Fired, amplitudes: Mapping[str, float], seed: int) -> PoseData:
    """Return the poses that the camera saw, with the sigmas that were stated of them."""
    seen = measure(fired, switched(amplitudes), seed, SILENCE)
    frame = np.rint(data.times_s * FRAME_RATE_HZ).astype(np.intp)
    shot = np.asarray(data.shots)[:, None] - 1
    turned = seen.orientations[shot, frame]
    matrices = Rotation.from_quat(turned.reshape(-1, 4), scalar_first=True).as_matrix()
    return replace(
        data,
        position=seen.centres[shot, frame],
        rotation=matrices.reshape(*turned.shape[:-1], 3, 3),
    )
