"""What was left out of a fit, and how large the noise was taken to be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from analysis.model.fitting.summary import FitSummary
from analysis.schema.verdict import TornTrack

AS_STATED = (1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Account:
    """What a fit was given of a campaign.

    Attributes
    ----------
    excluded
        Numbers of the shots that a person left out.
    rejected
        Why each shot that could not be used, or lies too far from the rest, was left out, by its
        number.
    frames
        (shot number, frame index) of frames that were taken out of shots that were kept.
    noise
        By what stated sigmas of positions and of orientations were multiplied.
    torn
        Shot number, sphere, first and last frame of what was cut of tracks that leave free flight.
    """

    excluded: list[int]
    rejected: Mapping[int, str]
    frames: tuple[tuple[int, int], ...]
    noise: tuple[float, float]
    torn: tuple[TornTrack, ...] = ()

    def remarks(self) -> list[str]:
        """Say what was left out, and where stated sigmas were not believed."""
        found = []
        if self.excluded:
            found.append(f"shots that a person excluded: {self.excluded}")
        if self.rejected:
            shots = (f"{number} ({why})" for number, why in self.rejected.items())
            found.append(f"shots left out as unlike the rest: {', '.join(shots)}")
        if self.frames:
            frames = [f"{frame} of shot {shot}" for shot, frame in self.frames]
            found.append(f"frames left out: {', '.join(frames)}")
        if self.torn:
            tracks = (
                f"frames {first} to {last} of sphere {sphere} in shot {shot}"
                for shot, sphere, first, last in self.torn
            )
            found.append(
                "left out where a track leaves free flight (a second contact, a tube, an outline"
                f" that was lost): {', '.join(tracks)}"
            )
        if self.noise != AS_STATED:
            position, rotation = self.noise
            found.append(
                f"the scatter about free flight is {position:.3g} times the stated sigmas of "
                f"positions and {rotation:.3g} times those of orientations: these were used"
            )
        return found


class Accounted(Protocol):
    """A campaign with a fit, wherever its poses are kept."""

    @property
    def fit(self) -> FitSummary:
        """What was found."""

    @property
    def account(self) -> Account:
        """What it was found from."""
