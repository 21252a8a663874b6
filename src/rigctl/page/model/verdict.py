"""The verdict in words: of the fit at hand, and of the search that the daemon makes by itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from nicegui import ui

from analysis.model.fitting.nuisance_words import alarm_sentences
from analysis.model.verdict.standing import (
    OPEN,
    SURE,
    Standing,
    Word,
    failing_rows,
    standing_of,
)
from analysis.model.verdict.words import doubts, too_few, verdict_sentence
from analysis.schema.codec import read
from analysis.schema.verdict import Nuisance, VerdictReport
from rigctl.documents import Json
from rigctl.page.desk import Desk
from rigctl.page.model.law import ProposedLaw, on_page
from rigctl.page.model.state import Effects, ModelState, Question
from rigctl.page.model.story.errors import Unseen
from rigctl.page.model.where import named
from rigctl.page.parts.waiting import Waiting
from rigctl.page.parts.widgets import button

MARKS = {True: ("good", "✓"), False: ("bad", "!"), None: ("open", "?")}
"""Look and mark of a verdict: all is well, something is missing, these shots do not say."""


def unnamed(found: VerdictReport, *, errors: bool = True) -> str:
    """Say with what the whole way ended, without the campaign's name."""
    return verdict_sentence(found, errors=errors).removeprefix(f"{found.campaign}: ")


def without_numbers(found: VerdictReport) -> str:
    """Say it as `unnamed`, without errors: the story gives those of the same fits."""
    return unnamed(found, errors=False)


def by_surety(found: Json, _standing: Standing) -> Sequence[Json]:
    """Return the findings of a fit as it has them, the surest first."""
    findings: list[Json] = found["findings"]
    return findings


@dataclass(frozen=True, slots=True)
class Wording:
    """How a view says things: sentences of a verdict, those of a proposed law, and findings.

    `found` says with what the whole way ended, `alarms` which stated numbers the fit pulls away;
    `first` puts the findings of a fit in the order in which they are named.
    """

    verdict: Callable[[str], str] = str
    found: Callable[[VerdictReport], str] = unnamed
    law: Callable[[str], str] = on_page
    finding: Callable[[Json], str] = named
    alarms: Callable[[Sequence[Nuisance]], list[str]] = alarm_sentences
    first: Callable[[Json, Standing], Sequence[Json]] = by_surety


class Verdict:
    """One sentence before any table, and a button that has the whole way gone.

    What the whole way ends with is taken into the model by `take`, so that there is one verdict.
    """

    def __init__(
        self,
        desk: Desk,
        state: ModelState,
        take: Callable[[Effects], None],
        wording: Wording = Wording(),
    ) -> None:
        self._state, self._take, self._worded = state, take, wording.verdict
        self._found_words = wording.found
        self._finding, self._alarmed, self._first = wording.finding, wording.alarms, wording.first
        jobs = state.source.daemon.jobs
        self._asked = Question(
            lambda: state.source.ask("explain"), jobs.job, state.source.without_its_folder
        )
        self._law = ProposedLaw(state, self.show.refresh, wording.law)
        self.show()
        explaining, running = "Finding what is missing", lambda: self._asked.running or ""
        Waiting(desk, explaining, running, "explaining", wording.verdict)
        Waiting(desk, "Looking for a law", lambda: self._law.running, "proposing", wording.verdict)

    def follow(self) -> None:
        """Show the answer once it has come."""
        came = self._asked.follow()
        if self._law.follow() or came:
            if came and self._asked.answer is not None:
                found = self._state.concluded = read(VerdictReport, self._asked.answer)
                # Also where it ends with what was there: story and next shots say what it says.
                self._take(found.path[-1].effects)
            self.show.refresh()

    @ui.refreshable_method
    def show(self) -> None:
        """Place what is known now."""
        present = self._state.present
        if present is None and not self._state.failure and not self._state.path():
            # What is waited for stands below, with its step and the time left.
            return
        lead, rest, good = ("Comparing model and measurement …", "", None)
        if self._state.failure:
            lead = "Model and measurement were not compared."
        if present is not None:
            lead, rest, good = sentence(
                self._state.path(),
                self._state.concluded,
                self._finding,
                self._state.trials(),
                self._first,
            )
        look, mark = MARKS[good] if present is not None else ("waits", "…")
        with ui.element("div").classes(f"verdict {look}").props("data-testid=verdict role=status"):
            with ui.element("div").classes("beside"):
                ui.label(mark).classes("verdict-mark").props("aria-hidden=true")
                with ui.element("div").classes("said"):
                    ui.label(self._worded(lead)).classes("lead")
                    ui.label(self._worded(rest))
                    self._alarms([read(Nuisance, one) for one in (present or {}).get("alarms", ())])
                self._offer()
            self._found()

    def _alarms(self, alarms: Sequence[Nuisance]) -> None:
        """Say which stated numbers the fit pulls away, folded up: a remark, no verdict."""
        if not alarms:
            return
        with ui.element("details").classes("note").props("data-testid=alarms"):
            standing = self._state.standing
            summary = doubted(len(alarms), Word.FEW if standing is None else standing.word)
            ui.html(summary, sanitize=False, tag="summary")
            for sentence in self._alarmed(alarms):
                ui.label(sentence).props("data-testid=alarm")

    def _offer(self) -> None:
        if self._asked.running is None and self._asked.answer is None:
            placed = button("Find it by itself", self._start, testid="explain")
            placed.tooltip("adds effects, drops them again and judges, until nothing is missing")

    def _found(self) -> None:
        if self._asked.failure:
            ui.label(self._asked.failure).classes("note")
        found = self._state.concluded
        if found is not None and self._asked.answer is not None:
            said = f"Found by itself: {self._found_words(found)}"
            ui.label(self._worded(said)).props("data-testid=explained")
            for doubt in doubts(found):
                ui.label(doubt).classes("note")
        if self._is_unexplained():
            self._law.show()

    def _is_unexplained(self) -> bool:
        """Whether the whole way, or before it the fit at hand, says that nothing known explains."""
        found, standing = self._state.concluded, self._state.standing
        if found is not None and self._asked.answer is not None:
            return found.unexplained
        return standing is not None and standing.word is Word.UNEXPLAINED

    def _start(self) -> None:
        self._asked.start()
        self.show.refresh()


def doubted(count: int, word: Word) -> str:
    """Say that the fit pulls so many stated numbers away.

    While something is missing in the model they take its place, and are no evidence of themselves:
    they are doubted once nothing is.
    """
    one = count == 1
    numbers = f"{'1 stated number' if one else f'{count} stated numbers'} of the set-up"
    if word in OPEN:
        bent = "is" if one else "are"
        return f"{numbers} {bent} bent by what is missing: look again once it is added"
    if word in {Word.FEW, Word.UNSURE}:
        fits = "fits" if one else "fit"
        return f"{numbers} {fits} badly: if something is missing, more shots would show it"
    return f"{numbers} {'is' if one else 'are'} in doubt"


def sentence(
    path: Sequence[Json],
    concluded: VerdictReport | None = None,
    finding: Callable[[Json], str] = named,
    tried: Mapping[str, float] | None = None,
    first: Callable[[Json, Standing], Sequence[Json]] = by_surety,
) -> tuple[str, str, bool | None]:
    """Say how the last fit of a path stands: the point, what goes with it, whether all is well.

    None where these shots do not say. What is said is decided by `standing_of` alone.
    """
    found, standing = path[-1], standing_of(path, concluded, tried)
    error = Unseen.of(found).sentence()
    added = " and ".join(found["with"])
    named_first = first(found, standing)
    surely = "most surely " if named_first[0] is found["findings"][0] else ""
    where = f"{surely}in {_worst(failing_rows(found), named_first, finding)}"
    match standing.word:
        case Word.FEW:
            return "Too few shots to tell.", f"{error}; {too_few(found['shots'])}", None
        case Word.UNSURE:
            lead = (
                f"With {added} nothing more is sure." if added else "Nothing is sure to be missing."
            )
            return lead, f"{error}; {_of_single_shots(where)}", None
        case Word.FLOOR:
            lead = f"With {added} nothing stands out." if added else "Nothing stands out."
            return lead, f"{error}: these shots show no more than their own noise.", True
        case Word.ALIKE:
            one, other = standing.tell or ("", "")
            lead = f"{one} or {other}: these shots cannot tell."
            return lead, f"{error}, with either of them; the next shots below would tell.", None
        case Word.MISSING:
            what, why = _missing(found, standing, where)
            return _still(added, what), f"{error}; {why}.", False
        case Word.UNEXPLAINED:
            rest = f"{error}; it shows {where}, and no effect that is known explains it."
            return _still(added), rest, False


def _missing(found: Json, standing: Standing, where: str) -> tuple[str, str]:
    """Return how much is missing, and what shows it; at the floor only all shots together do."""
    best = standing.missing[0]
    also = f", which these shots do not tell from {standing.tell[1]}," if standing.tell else ""
    if failing_rows(found) or found["findings"][0]["p_familywise"] < SURE:
        return "something", f"it shows {where}. {best}{also} lowers it most"
    lowers = f"{best}{also} lowers it most, over all shots together"
    return "something small", f"no single quantity shows it. {lowers}"


def _still(added: str, what: str = "something") -> str:
    return f"With {added} {what} is still missing." if added else f"{what.capitalize()} is missing."


def _of_single_shots(where: str) -> str:
    return (
        f"what stands out, {where}, may be errors of single shots. More shots at several speeds "
        "and angles would tell."
    )


def _worst(fails: list[Json], found: Sequence[Json], finding: Callable[[Json], str]) -> str:
    """Name what stands out most: the first finding if it does, else the quantity that disagrees."""
    worst = found[0]
    if worst["p_familywise"] >= SURE and fails:
        return finding(min(fails, key=lambda row: row["p_familywise"]))
    return finding(worst)
