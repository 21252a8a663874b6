"""A challenge: a campaign folder that hides something, and the sealed label that says what."""

from __future__ import annotations

import secrets
from pathlib import Path

import numpy as np

from simulators.challenge.camera import OPTICS
from simulators.challenge.campaign import fire, run_campaign
from simulators.challenge.effects import STRENGTHS, switched
from simulators.challenge.folder import write_folder, write_frames
from simulators.challenge.label import Amplitudes, draw_label, label_document
from simulators.challenge.launch import FILMED_PRESSURES_KPA
from simulators.challenge.pictures import filmed
from simulators.challenge.seal import write_seal

FEWEST_SHOTS, MOST_SHOTS = 3, 10_000
_LABEL, _SALT, _CAMPAIGN = range(3)


def new_challenge(
    folder: Path,
    *,
    seed: int | None = None,
    strength: str = "full",
    shots: int = 120,
    from_frames: bool = False,
) -> None:
    """Draw what to hide and write the campaign with its seal.

    A seed gives the same folder to the last byte, but for the campaign's name, which is the
    folder's; without one the system's entropy is drawn.

    Raises
    ------
    ValueError
        The folder holds something, the strength is unknown, the seed negative or the number of
        shots out of range.
    OSError
        The folder cannot be written.
    """
    seed = secrets.randbits(63) if seed is None else seed
    if seed < 0:
        raise ValueError(f"the seed must not be negative, found {seed}")
    if strength not in STRENGTHS:
        raise ValueError(f"strength must be one of {', '.join(STRENGTHS)}, found {strength!r}")
    label = draw_label(np.random.default_rng([seed, _LABEL]), strength)
    write_challenge(folder, label, seed, shots, from_frames=from_frames)


def write_challenge(
    folder: Path,
    amplitudes: Amplitudes,
    seed: int,
    shots: int = 120,
    *,
    from_frames: bool = False,
) -> None:
    """Write a campaign that hides the named effects, at these amplitudes, with its seal.

    Poses with noise, or frames of the same shots.

    Raises
    ------
    ValueError
        The folder holds something, or the number of shots is out of range.
    OSError
        The folder cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ValueError(f"{folder} holds something already; name a folder that is not there")
    if not FEWEST_SHOTS <= shots <= MOST_SHOTS:
        raise ValueError(f"shots must be {FEWEST_SHOTS} to {MOST_SHOTS}, found {shots}")
    nature, own_seed = switched(amplitudes), campaign_seed(seed)
    if from_frames:
        fired = fire(nature, own_seed, shots=shots, pressures_kpa=FILMED_PRESSURES_KPA)
        write_frames(folder, fired.settings, filmed(fired, nature, OPTICS, own_seed))
    else:
        write_folder(folder, run_campaign(nature, own_seed, shots=shots))
    write_seal(folder, label_document(amplitudes), np.random.default_rng([seed, _SALT]))


def campaign_seed(seed: int) -> int:
    """Return the seed of a challenge's campaign; its streams overlap with no other's."""
    return int(np.random.default_rng([seed, _CAMPAIGN]).integers(2**62))
