"""The error on shots that the model has not seen, as the story states it.

Where errors of measurement are stated it is a multiple of the noise, and 1 is the floor. Where they
are estimated from the scatter about each fit, that multiple is about 1 for every fit; the story
then states the error in the unit of what was measured, with the scatter of the present fit beside.
"""

from __future__ import annotations

from dataclasses import dataclass

from rigctl.documents import Json


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

    @property
    def digits(self) -> int:
        """Decimals of the value in words."""
        return 3 if self.floor is not None else max(0, 2 - len(str(int(self.value))) + 1)

    def said(self) -> str:
        """Return it in words."""
        return f"{self.value:.{self.digits}f} {self.unit}"

    def sentence(self) -> str:
        """Return how well shots that were left out are predicted."""
        if self.floor is None:
            return f"Shots left out are predicted to {self.said()}"
        return f"The error on shots left out is {self.value:.3f} of the noise"
