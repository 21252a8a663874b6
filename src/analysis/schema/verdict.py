"""A fit of a campaign and the verdict on it, as commands, REST and page hand them on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from analysis.quantity import Measured
from analysis.schema.codec import BESIDE, STRICT, NotNegative, named

Count = Annotated[int, Field(ge=0)]
Chance = Annotated[float, Field(ge=0, le=1)]
TornTrack = tuple[int, str, int, int]
"""Shot number, sphere, first and last frame index of what was cut of a track."""
Verdicts = Literal["none", "effect", "alias", "unexplained"]


@dataclass(frozen=True, slots=True, config=STRICT)
class NoiseFactors:
    """By what stated sigmas of positions and of orientations were multiplied; 1: as stated."""

    position: NotNegative
    orientation: NotNegative


@dataclass(frozen=True, slots=True, config=STRICT)
class Nuisance:
    """One parameter that all shots share and that is stated beforehand.

    Attributes
    ----------
    name
        `effect.symbol`.
    stated, found
        What is stated of it, and what the fit makes of it.
    pull
        How many stated errors the fit has it from its stated value.
    """

    name: Annotated[str, named("nuisance", "name")]
    stated: Measured
    found: Measured
    pull: float


@dataclass(frozen=True, slots=True, config=BESIDE, kw_only=True)
class FitReport:
    """The law and some effects, fitted to all shots together.

    Attributes
    ----------
    shots
        How many were fitted.
    excluded, rejected
        Numbers of the shots that a person left out, and that were left out as unlike the rest.
    rejected_why
        Of each of these why, in the same order; documents of before have none.
    rejected_frames
        (shot number, frame index) of frames that were taken out of shots that were kept.
    torn_tracks
        Shot number, sphere, first and last frame of what was cut of tracks that leave free flight;
        documents of before have no frames.
    effects
        Names of those that were added; `with` in JSON.
    converged
        Whether a further step would lower chi-squared by less than what matters.
    formulas
        Of the added effects, by name, with what is held in them, such as the speed of a knee.
    nuisances, alarms
        All that is stated beforehand; of it what the fit pulls far away, the farthest first.
    """

    campaign: str
    shots: Count
    excluded: tuple[int, ...]
    rejected: tuple[int, ...]
    rejected_frames: tuple[tuple[int, int], ...]
    torn_tracks: tuple[TornTrack | tuple[int, str], ...]
    noise: NoiseFactors
    effects: Annotated[tuple[str, ...], named("with", "effects")]
    chi2_per_dof: NotNegative
    degrees_of_freedom: int
    converged: bool
    parameters: Mapping[str, Measured]
    formulas: Mapping[str, str] = Field(default_factory=dict)
    rejected_why: tuple[str, ...] = ()
    nuisances: tuple[Nuisance, ...] = ()
    alarms: tuple[Nuisance, ...] = ()


@dataclass(frozen=True, slots=True, config=STRICT)
class PathStage:
    """One stage on the way to a verdict: the base model with some effects.

    `prediction_error` is that on shots left out, in units of the noise: 1 is the floor.
    """

    effects: Annotated[tuple[str, ...], named("with", "effects")]
    chi2_per_dof: NotNegative
    prediction_error: NotNegative


@dataclass(frozen=True, slots=True, config=STRICT, kw_only=True)
class SeenCandidate:
    """An effect that these shots hold information on, scored before any effect was added.

    Attributes
    ----------
    score
        Signed root of the expected drop of chi-squared for one parameter, the root for several.
    p_value, p_familywise
        Chance of the drop by itself, and with all effects looked at.
    delta_chi2
        Expected drop of chi-squared; `promised_fall` in JSON.
    amplitude, sigma, plausible_range
        Of its first parameter, in `unit`, with its standard error and what is believed of it.
    of_measurement, moved_m
        Whether slow errors of the images do as much, and by how many metres it moves places.
    """

    effect: str
    score: float
    p_value: Chance
    p_familywise: Chance
    delta_chi2: Annotated[float, named("promised_fall", "delta_chi2")]
    amplitude: float
    sigma: NotNegative
    unit: str
    plausible: bool
    of_measurement: bool
    moved_m: NotNegative | None
    plausible_range: tuple[float, float]


@dataclass(frozen=True, slots=True, config=STRICT, kw_only=True)
class RankedCandidate:
    """An effect that may be added to a fit, seen or not; None where it cannot be seen.

    Keys are those of `SeenCandidate`, and with them:

    Attributes
    ----------
    seen
        Whether these shots hold information on it.
    amplitudes
        Of all its parameters, by symbol.
    like
        Effects that these shots do not tell from it.
    """

    effect: str
    seen: bool
    score: float | None
    delta_chi2: Annotated[float, named("promised_fall", "delta_chi2")]
    p_value: Chance
    p_familywise: Chance
    plausible: bool | None
    of_measurement: bool
    moved_m: NotNegative | None
    amplitude: float | None
    unit: str
    amplitudes: Mapping[str, Measured]
    like: tuple[str, ...]


@dataclass(frozen=True, slots=True, config=STRICT, kw_only=True)
class TestedCell:
    """What is disturbed, against what it depends on.

    `p_value` is that of the cell by itself, `p_familywise` with all cells looked at.
    """

    channel: str
    covariate: str
    chi2: float
    degrees_of_freedom: Count
    p_value: Chance
    p_familywise: Chance


@dataclass(frozen=True, slots=True, config=STRICT, kw_only=True)
class LeftCell(TestedCell):
    """Structure that is left; `of_measurement`: whether slow errors of the poses do as much."""

    of_measurement: bool


@dataclass(frozen=True, slots=True, config=STRICT)
class NextShot:
    """Settings to fire next, and how often: gauge pressures in kPa, tube b below a in mm."""

    pressure_a_kpa: float
    pressure_b_kpa: float
    offset_mm: float
    repeat: Annotated[int, Field(ge=1)]


@dataclass(frozen=True, slots=True, config=BESIDE, kw_only=True)
class VerdictReport:
    """What is concluded of a campaign.

    Attributes
    ----------
    shots, used
        How many there are, and how many of them were fitted.
    effects
        Names of the accepted effects; when unexplained, what explains part.
    alias_set, alias_sets
        All that may be meant, and all that these shots cannot tell from each accepted effect.
    p_chi2
        Chance of so large a chi-squared when nothing is missing and the sigmas are true.
    path
        From the base model on.
    formulas
        As in `FitReport`.
    candidates
        Before any effect was added, the most promising first.
    structure
        That is left, what more than two shots carry first.
    next_shots
        That would end the doubts.
    """

    campaign: str
    shots: Count
    used: Count
    excluded: tuple[int, ...] = ()
    rejected: tuple[int, ...] = ()
    rejected_frames: tuple[tuple[int, int], ...] = ()
    torn_tracks: tuple[TornTrack | tuple[int, str], ...] = ()
    verdict: Verdicts
    effects: tuple[str, ...]
    alias_set: tuple[str, ...] = ()
    alias_sets: Mapping[str, tuple[str, ...]] = Field(default_factory=dict)
    unexplained: bool
    chi2_per_dof: NotNegative
    p_chi2: Chance
    path: tuple[PathStage, ...]
    parameters: Mapping[str, Measured]
    formulas: Mapping[str, str] = Field(default_factory=dict)
    nuisances: tuple[Nuisance, ...] = ()
    alarms: tuple[Nuisance, ...] = ()
    candidates: tuple[SeenCandidate, ...] = ()
    noise: NoiseFactors
    structure: tuple[LeftCell, ...] = ()
    next_shots: tuple[NextShot, ...] = ()
