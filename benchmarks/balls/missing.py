"""Films that lack frames, and whether that is noticed: python -m benchmarks.balls.missing.

Drawn films, and those of campaigns' folders with a truth.json, are measured whole and without one
to three of their frames: at bounces, next to them, at tops, in flight, and near both ends. Counted
is what a person is told, and whether each e is within three of its errors of the drawn one.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from analysis.balls.analysis import AnalysedFilm, analyse_held
from analysis.balls.films.film import Film, Picture
from analysis.balls.films.reading import film_of_shot, open_film
from analysis.balls.flight.known import Ball
from analysis.balls.gaps import frame_at
from analysis.balls.measuring import coefficient
from analysis.errors import ShotRefusedError
from analysis.exchange.description import read_description
from benchmarks.balls.filming import film
from benchmarks.balls.scenes import KINDS, scene

MOST_PULL = 3.0
NEAR_FRAMES = 4.0
"""From a measured bounce to the drawn one that it is."""
TOLD = ("missing", "rate varies", "has all frames")
"""What remarks say of frames that are missing, of the rate, and of one bounce alone."""
OUTCOMES = (
    "mended",
    "said",
    "harmless",
    "fewer bounces",
    "wrong in silence",
    "mended wrongly",
    "refused",
)


@dataclass(frozen=True, slots=True)
class Drawn:
    """A film in memory beside its truth.

    Attributes
    ----------
    name, film, ball, rate_hz, exposure_s
        As a person would state them.
    bounces
        Frame number and e of each.
    """

    name: str
    film: Film
    ball: Ball
    rate_hz: float
    exposure_s: float | None
    bounces: tuple[tuple[float, float], ...]


class Lacking(Film):
    """A film without some of its frames; its times go on as if none were missing."""

    def __init__(self, whole: Film, first: int, count: int) -> None:
        super().__init__(whole.path, replace(whole.head, frames=whole.head.frames - count))
        self._whole, self._out = whole, range(first, first + count)

    def _read(self) -> Iterator[Picture]:
        for number, picture in enumerate(self._whole.pictures()):
            if number not in self._out:
                yield picture


def places(drawn: Drawn, bounces: int, rng: np.random.Generator) -> Iterator[tuple[str, int, int]]:
    """Give what is taken out: where that is, the first frame and how many.

    Parameters
    ----------
    bounces
        How many of the whole film are measured.
    """
    last = drawn.film.head.frames - 1
    contacts = [at for at, _ in drawn.bounces[:bounces]]
    ends = [0.0, *contacts, float(last)]
    wanted: list[tuple[str, float]] = []
    for at in contacts:
        wanted += [("at a bounce", at), ("before a bounce", at - rng.uniform(1.5, 4.0))]
        wanted += [("after a bounce", at + rng.uniform(1.5, 4.0))]
    for a, b in pairwise(ends):
        wanted += [("at a top", 0.5 * (a + b)), ("in flight", rng.uniform(a, b))]
    wanted += [("near an end", rng.uniform(1.0, 6.0)), ("near an end", last - rng.uniform(1, 6))]
    for where, at in wanted:
        count = int(rng.integers(1, 4))
        # What is taken out at a bounce has the bounce in its middle.
        first = int(np.ceil(at - 0.5 * count))
        if first >= 1 and first + count < last:
            yield where, first, count


@dataclass(frozen=True, slots=True)
class Told:
    """What a person is told of a film.

    Attributes
    ----------
    outcome
        One of OUTCOMES.
    pull
        The largest of e: error over stated error.
    bounces
        How many are measured.
    said
        Of frames that are missing, or of the rate.
    """

    outcome: str
    pull: float
    bounces: int
    said: tuple[str, ...]


def told(drawn: Drawn, first: int = 0, count: int = 0, whole: Told | None = None) -> Told:
    """Measure a film without some frames; what is said of the whole one too is no notice."""
    lacking = Lacking(drawn.film, first, count) if count else drawn.film
    times = np.arange(lacking.head.frames) / drawn.rate_hz
    try:
        found = analyse_held(lacking, times, drawn.ball, drawn.exposure_s)
    except ShotRefusedError as refusal:
        return Told("refused", np.inf, 0, (str(refusal),))
    usual = () if whole is None else whole.said
    said = [
        note for note in found.notes if any(word in note for word in TOLD) and note not in usual
    ]
    # A bounce that was cut out lies between the frames beside it.
    known = [(at if at < first else max(first - 0.5, at - count), e) for at, e in drawn.bounces]
    pull = _largest_pull(found, known)
    if found.measured.gaps:
        outcome = "mended" if pull < MOST_PULL else "mended wrongly"
    elif said:
        outcome = "said"
    elif pull >= MOST_PULL:
        outcome = "wrong in silence"
    else:
        fewer = whole is not None and found.measured.bounces < whole.bounces
        outcome = "fewer bounces" if fewer else "harmless"
    return Told(outcome, pull, found.measured.bounces, tuple(said))


def _largest_pull(found: AnalysedFilm, known: list[tuple[float, float]]) -> float:
    """Return the largest pull of e; infinite where a bounce is none."""
    measured, pulls = found.measured, [0.0]
    flights = measured.flights
    for bounce in range(measured.bounces):
        assert flights is not None
        value, sigma = coefficient(measured, bounce)
        at = frame_at(measured.times_s, float(flights.contacts[bounce, 0]))
        away, e = min((abs(at - frame), e) for frame, e in known)
        pulls.append(abs(value - e) / sigma if away < NEAR_FRAMES else np.inf)
    return max(pulls)


def films(kinds: list[str], seeds: range, home: Path) -> Iterator[Drawn]:
    """Draw films of some cameras, or find those that were drawn before."""
    for kind in kinds:
        for seed in seeds:
            drawn = scene(kind, seed)
            folder = home / f"{kind.replace(' ', '')}-{seed}"
            truth = film(folder, drawn, seed)
            _, drop, camera, _ = drawn
            density = drop.mass / (np.pi / 6 * drop.diameter**3)
            yield Drawn(
                folder.name,
                open_film(film_of_shot(folder / "frames", 1)),
                Ball(drop.diameter, density=density),
                camera.rate_hz,
                camera.exposure_s if kind == "12 bits" else None,
                tuple((each.time * camera.rate_hz, each.e) for each in truth.bounces),
            )


def of_folder(folder: Path) -> Drawn:
    """Return the film of a campaign's folder with its truth."""
    _, setup = read_description(folder / "campaign.toml")
    bounces = json.loads((folder / "truth.json").read_text())["bounces"]
    rate = setup.camera.frame_rate_hz
    assert rate is not None
    return Drawn(
        folder.name,
        open_film(film_of_shot(folder / "frames", 1)),
        Ball.of_setup(setup),
        rate,
        None,
        tuple((each["frame"], each["e"]) for each in bounces),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folders", nargs="*", type=Path, help="campaigns with a truth.json")
    parser.add_argument("--films", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kinds", nargs="*", choices=KINDS, default=list(KINDS))
    parser.add_argument("--keep", type=Path, help="folder for the films")
    asked = parser.parse_args()
    home = asked.keep or Path(tempfile.mkdtemp())
    seeds = range(asked.first, asked.first + asked.films)
    counts: dict[str, Counter[str]] = {}
    drawn_films = [*map(of_folder, asked.folders), *films(asked.kinds, seeds, home)]
    for number, drawn in enumerate(drawn_films):
        whole = told(drawn)
        counts.setdefault("whole", Counter())[whole.outcome] += 1
        print(
            f"{drawn.name}, whole: {whole.outcome}, pull {whole.pull:.1f}; {'; '.join(whole.said)}"
        )
        rng = np.random.default_rng([asked.first, number])
        for where, first, count in places(drawn, whole.bounces, rng):
            own = told(drawn, first, count, whole)
            counts.setdefault(where, Counter())[own.outcome] += 1
            print(
                f"{drawn.name}, {count} out at {first}, {where}: {own.outcome}, {own.bounces} "
                f"bounces, pull {own.pull:.1f}; {'; '.join(own.said)}",
                flush=True,
            )
    print("".join(f"{each:>18}" for each in ("", *OUTCOMES)))
    for where, count_of in counts.items():
        print("".join(f"{each:>18}" for each in (where, *(count_of[o] for o in OUTCOMES))))


if __name__ == "__main__":
    main()
