"""What a fit leaves open, decided in one place: verdict, what is missing and next shots say it.

Works on the documents that fits and verdicts are handed on as, so that whoever shows them decides
nothing anew. Campaigns of at most `FEW` shots are judged with care: two of them may err.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

from analysis.model.structure.alarm import FEWEST
from analysis.model.structure.influence import FEW
from analysis.schema.codec import Json
from analysis.schema.verdict import VerdictReport

SURE = 0.01
"""Family-wise chance below which a row, a cell or an effect counts."""
AT_THE_FLOOR = 1.01
"""Error on unseen shots over the noise up to which one cell alone is no finding, where every
quantity agrees and no effect stands out: nothing could lower it by more than a hundredth."""


WORTH = 0.99
"""An effect that leaves more than this part of the error on unseen shots explains nothing."""


class Word(StrEnum):
    """What is said of a model.

    `few`: too few shots to say. `floor`: nothing is missing that these shots show. `unsure`: what
    stands out may be errors of single shots. `alike`: nothing is missing, but another effect would
    have done the same. `missing`: known effects would explain it. `unexplained`: none would.
    """

    FEW = "few"
    FLOOR = "floor"
    UNSURE = "unsure"
    ALIKE = "alike"
    MISSING = "missing"
    UNEXPLAINED = "unexplained"


OPEN = frozenset({Word.MISSING, Word.UNEXPLAINED})
"""Words under which something is said to be missing; under every other one nothing is."""


@dataclass(frozen=True, slots=True)
class Standing:
    """How a model stands.

    Attributes
    ----------
    word
        What is said of it.
    missing
        Effects that are still missing, the most promising first; none unless `word` is `missing`.
    tell
        Two effects that next shots should tell apart; None where no shots are needed to name one.
    """

    word: Word
    missing: tuple[str, ...] = ()
    tell: tuple[str, str] | None = None

    @property
    def is_open(self) -> bool:
        """Whether something is said to be missing."""
        return self.word in OPEN


def standing_of(
    path: Sequence[Json],
    concluded: VerdictReport | None = None,
    tried: Mapping[str, float] | None = None,
) -> Standing:
    """Return how the last of some fits stands.

    Parameters
    ----------
    path
        Documents of the fits from the base model on, each with one more effect than the one
        before: agreement, cells and ranking.
    concluded
        Verdict of the whole way, where it is known: it decides for the model that it ended with.
    tried
        By which factor one more effect changes the error on unseen shots, by its name: one that
        was fitted in full is judged by that, in the place of what its score promises.
    """
    found = path[-1]
    if found["shots"] < FEWEST:
        return Standing(Word.FEW)
    if concluded is not None and set(concluded.effects) == set(found["with"]):
        return _concluded(concluded)
    strong = strong_effects(found)
    fails, left = failing_rows(found), left_cells(found)
    shared = [cell for cell in left if cell["shared"]]
    structured = bool(left) and found["prediction_error"] > AT_THE_FLOOR
    if not (shared or strong):
        doubtful = not stands_without_two(fails) and not structured
        if (fails and doubtful) or (found["shots"] <= FEW and (fails or left)):
            return Standing(Word.UNSURE)
    tried = tried or {}
    in_vain = strong and strong[0]["effect"] in tried and not _any_helps(found, strong, tried)
    if strong and not (in_vain and (fails or structured)):
        return Standing(Word.MISSING, _names(strong), _pair(strong[0], _names(strong)))
    if fails or structured:
        return Standing(Word.UNEXPLAINED)
    pair = _added_pair(path)
    return Standing(Word.FLOOR) if pair is None else Standing(Word.ALIKE, tell=pair)


def strong_effects(found: Json) -> list[Json]:
    """Return the candidates that stand out and are not in the model, the best first."""
    return [
        candidate
        for candidate in found["candidates"]
        if candidate["seen"]
        and not candidate["of_measurement"]
        and candidate["p_familywise"] < SURE
        and candidate["effect"] not in found["with"]
    ]


def failing_rows(found: Json) -> list[Json]:
    """Return the quantities that disagree with the model."""
    rows = [row for stage in found["stages"] for row in stage["quantities"]]
    return [row for row in rows if row["p_familywise"] < SURE]


def stands_without_two(fails: Sequence[Json]) -> bool:
    """Say whether one of these quantities disagrees without its two worst shots too."""
    return any(row["shared"] for row in fails)


def left_cells(found: Json) -> list[Json]:
    """Return the cells in which structure is left."""
    return [cell for cell in found["cells"] if cell["p_familywise"] < SURE]


def _any_helps(found: Json, strong: Sequence[Json], tried: Mapping[str, float]) -> bool:
    """Say whether one of these effects lowers the error on unseen shots, or promises to."""
    return any(
        tried.get(one["effect"], promised_error(found, one) / found["prediction_error"]) < WORTH
        for one in strong
    )


def promised_error(found: Json, candidate: Json) -> float:
    """Return about how far the error on unseen shots would fall with an effect, by its score.

    Its fall is in units of the noise as it was found, of which each degree of freedom has one.
    """
    left = 1.0 - candidate["promised_fall"] / found["degrees_of_freedom"]
    return float(found["prediction_error"] * math.sqrt(max(0.0, left)))


def _concluded(verdict: VerdictReport) -> Standing:
    if verdict.unexplained:
        return Standing(Word.UNEXPLAINED)
    alike = verdict.alias_set
    if verdict.verdict == "alias" and len(alike) > 1:
        return Standing(Word.ALIKE, tell=(alike[0], alike[1]))
    return Standing(Word.FLOOR)


def _names(candidates: Sequence[Json]) -> tuple[str, ...]:
    return tuple(candidate["effect"] for candidate in candidates)


def _pair(best: Json, strong: Sequence[str]) -> tuple[str, str] | None:
    """Return an effect and the first of those that stand out which these shots do not tell from it.

    None where it has no company: then no further shots are needed to name it.
    """
    like = next((name for name in best["like"] if name in strong), None)
    return None if like is None else (best["effect"], like)


def _added_pair(path: Sequence[Json]) -> tuple[str, str] | None:
    """Return an effect of the model and one that would have done as well when it was added."""
    for before, after in pairwise(path):
        strong = strong_effects(before)
        for candidate in strong:
            if candidate["effect"] in after["with"]:
                pair = _pair(candidate, _names(strong))
                if pair is not None and pair[1] not in path[-1]["with"]:
                    return pair
    return None
