"""Where a fit and its campaign agree, and the structure that is left, as others read them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from analysis.schema.codec import BESIDE, STRICT, NotNegative
from analysis.schema.verdict import Chance, Count, TestedCell


@dataclass(frozen=True, slots=True, config=STRICT)
class NoiseScale:
    """By what stated sigmas are to be multiplied, and its error; None where it is not known."""

    value: NotNegative
    sigma: NotNegative | None


@dataclass(frozen=True, slots=True, config=STRICT, kw_only=True)
class AgreementRow:
    """One measured quantity held against its prediction.

    Attributes
    ----------
    count
        How many numbers it is made of.
    chi2, degrees_of_freedom
        Sum of squared whitened residuals, and what it is on average when nothing is missing.
    error, sampling
        Whitened error of the prediction, floor 1, and its standard deviation when nothing is
        missing.
    size, floor
        Root mean square of that error in `unit`, and what the noise alone makes of it.
    p_value, p_familywise
        Chance of as large a chi2 by noise alone, and with all lines of the table looked at.
    shared
        Whether it still disagrees without the two shots with the largest share, which may err by
        themselves; true where it is not made up of shots.
    """

    quantity: str
    unit: str
    count: Count
    chi2: NotNegative
    degrees_of_freedom: float
    error: NotNegative
    sampling: NotNegative
    size: NotNegative
    floor: NotNegative
    p_value: Chance
    p_familywise: Chance
    shared: bool = True


@dataclass(frozen=True, slots=True, config=STRICT)
class AgreementStage:
    """The quantities of one stage of the way from settings to image."""

    stage: str
    quantities: tuple[AgreementRow, ...]


@dataclass(frozen=True, slots=True, config=BESIDE, kw_only=True)
class AgreementReport:
    """A fit held against its campaign, by stages in the order of nature.

    Attributes
    ----------
    prediction_error, prediction_error_sampling
        Whitened error of the poses after contact of shots left out, and its sampling error.
    noise
        By `positions` and `orientations`: what the scatter about free flights says of the sigmas.
    """

    chi2: NotNegative
    degrees_of_freedom: int
    chi2_per_dof: NotNegative
    p_value: Chance
    prediction_error: NotNegative
    prediction_error_sampling: NotNegative
    noise: Mapping[str, NoiseScale]
    stages: tuple[AgreementStage, ...]


@dataclass(frozen=True, slots=True, config=STRICT, kw_only=True)
class SplitCell(TestedCell):
    """A cell by its parts, each in standard deviations.

    Attributes
    ----------
    deviation
        Of its course without its channel's mean.
    mean_deviation
        Of that mean.
    """

    deviation: NotNegative
    mean_deviation: NotNegative


@dataclass(frozen=True, slots=True, config=STRICT, kw_only=True)
class CountedCell(TestedCell):
    """A cell, and whether more than two shots speak for it."""

    shared: bool


@dataclass(frozen=True, slots=True, config=STRICT)
class Course:
    """A running mean with its standard error, arrays of one length."""

    x: tuple[float, ...]
    mean: tuple[float, ...]
    sigma: tuple[NotNegative, ...]


@dataclass(frozen=True, slots=True, config=BESIDE, kw_only=True)
class CellPoints:
    """The residuals of one cell, arrays of one length.

    Attributes
    ----------
    unit
        Of residual, sigma and mean: mm/s, rad/s, mm or mrad.
    frames
        Index of the frame in its shot; -1 where a point is the whole shot.
    x
        The covariate, in the unit that `x_label` ends with.
    """

    channel: str
    covariate: str
    x_label: str
    unit: str
    shots: tuple[int, ...]
    frames: tuple[Annotated[int, Field(ge=-1)], ...]
    x: tuple[float, ...]
    residual: tuple[float, ...]
    sigma: tuple[NotNegative, ...]
    trend: Course


@dataclass(frozen=True, slots=True, config=STRICT, kw_only=True)
class StructureReport:
    """All cells, the most striking first, and the residuals behind the first few."""

    cells: tuple[SplitCell, ...]
    residuals: tuple[CellPoints, ...]
