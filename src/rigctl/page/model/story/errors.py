"""The error on shots that the model has not seen, as the story states it.

Where errors of measurement are stated it is a multiple of the noise, and 1 is the floor. Where they
are estimated from the scatter about each fit, that multiple is about 1 for every fit; the story
then states the error in the unit of what was measured, with the scatter of the present fit beside.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from analysis.model.verdict.standing import promised_error
from rigctl.documents import Json

NEAR_ONE = 1.1
"""Multiples of the noise below which two that differ would often read alike to three figures."""


@dataclass(frozen=True, slots=True)
class Unseen:
    """An error on shots left out, with its unit, and what no model can go below.

    Attributes
    ----------
    floor
        None: not known, as no errors are stated.
    """

    value: float
    unit: str
    floor: float | None

    @classmethod
    def of(cls, found: Json) -> Unseen:
        """Return that of a fit's answer."""
        if not found.get("estimated"):
            return cls(found["prediction_error"], "×", 1.0)
        row = found["stages"][-1]["quantities"][0]
        return cls(row["size"], row["unit"], None)

    def said(self) -> str:
        """Return it in words, with its unit."""
        return f"{self.number()} {self.unit}"

    def number(self) -> str:
        """Return it without its unit."""
        return (three_figures if self.floor is None else decimals_near_one)(self.value)

    def sentence(self) -> str:
        """Return how well shots that the fit has not seen are predicted."""
        if self.floor is None:
            return f"Unseen shots are predicted to {self.said()}"
        return f"The error on unseen shots is {self.number()} times the noise"


def decimals_near_one(value: float) -> str:
    """Return a multiple of the noise: near the floor with three decimals, so that a fall is seen.

    The slider's script writes it alike.
    """
    return f"{value:.3f}" if value < NEAR_ONE else three_figures(value)


def three_figures(value: float) -> str:
    """Return a number as the slider's script writes it."""
    return f"{value:.0f}" if value >= 1000 else f"{value:#.3g}".rstrip(".")


def falls_to(found: Json, candidate: Json) -> Unseen:
    """Return about how far the error would fall with an effect, by its promised fall."""
    now = Unseen.of(found)
    share = promised_error(found, candidate) / found["prediction_error"]
    return replace(now, value=max(now.floor or 0.0, now.value * share))
