"""Which effects may be missing, and how the error falls as they are added."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from analysis.model.data.evidence import Stage
from analysis.model.rank.candidate import Ranking as Ranked
from analysis.model.verdict.documents import ranking_document
from rigctl.api.pictured import Pictured
from rigctl.documents import Json

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Ranking(Pictured):
    """All effects that are not in a fit, the most promising first; it is gone through by name."""

    def __init__(self, campaign: str, ranked: Ranked) -> None:
        self.campaign, self._ranked = campaign, ranked

    def __len__(self) -> int:
        """Return how many effects were scored."""
        return len(self._ranked.candidates)

    def __iter__(self) -> Iterator[str]:
        """Return their names."""
        return (candidate.effect.name for candidate in self._ranked.candidates)

    @property
    def best(self) -> str | None:
        """Name of the first; None where nothing can be seen in these shots."""
        return next((c.effect.name for c in self._ranked.candidates if c.seen), None)

    @property
    def p_familywise(self) -> float:
        """Share of campaigns with nothing missing in which some effect looks as good as the first.

        1 where nothing can be seen.
        """
        return next((c.p_familywise for c in self._ranked.candidates if c.seen), 1.0)

    def plot(self) -> Axes:
        """Draw the scores of the first effects with their alias sets."""
        from analysis.figures.ranking import ranking_figure  # noqa: PLC0415 - Matplotlib is slow

        return ranking_figure(f"{self.campaign}: what is missing", self._ranked).axes[0]

    def to_list(self) -> list[Json]:
        """Return the `candidates` of `rigctl model rank --json`."""
        return ranking_document(self._ranked)

    def _headline(self) -> str:
        return f"{self.campaign}: effects that may be missing"

    def _columns(self) -> Mapping[str, list[object]]:
        rows = self.to_list()
        shown = {
            "score": "score",
            "promised_fall": "promised_fall",
            "p": "p_familywise",
            "amplitude": "amplitude",
            "unit": "unit",
            "plausible": "plausible",
        }
        return {
            "effect": [row["effect"] for row in rows],
            **{name: [row[key] for row in rows] for name, key in shown.items()},
            "like": [", ".join(row["like"]) for row in rows],
            "why_no_score": [self._unseen(row) for row in rows],
        }

    def _unseen(self, row: Json) -> str:
        """Return why an effect has no score, and which shots would give it one."""
        if row["seen"]:
            return ""
        effect = next(c.effect for c in self._ranked.candidates if c.effect.name == row["effect"])
        return (
            "not determined: whatever its size, these shots would be the same. What would show it: "
            f"{effect.gives_away}"
        )


class ErrorPath(Pictured):
    """The error on shots left out after each effect, in units of the noise: noise alone gives 1."""

    def __init__(self, campaign: str, stages: Sequence[Stage]) -> None:
        self.campaign, self._stages = campaign, tuple(stages)

    @property
    def errors(self) -> tuple[float, ...]:
        """The error of each stage, the base model first."""
        return tuple(stage.error.value for stage in self._stages)

    def plot(self) -> Axes:
        """Draw the errors with the floor of the noise."""
        from analysis.figures.error_path import error_path_figure  # noqa: PLC0415 - as above

        return error_path_figure(f"{self.campaign}: error path", self._stages).axes[0]

    def _headline(self) -> str:
        return f"{self.campaign}: error on shots left out, in units of the noise"

    def _columns(self) -> Mapping[str, list[object]]:
        return {
            "with": [", ".join(stage.effects) or "the base model" for stage in self._stages],
            "chi2_per_dof": [stage.fit.chi2_per_dof for stage in self._stages],
            "prediction_error": list(self.errors),
            "sampling_error": [stage.error.sampling for stage in self._stages],
        }
