"""A film of a ball from file to result: what `rigctl analyse` does with one."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from analysis.arrays import Floats
from analysis.balls.carried import CarriedError, NotFlyingError, OtherFallError, TurningError
from analysis.balls.even import even_stretches, in_doubt, sure_bounces
from analysis.balls.films.distinct import DistinctFilm
from analysis.balls.films.fields import FieldsFilm, InterlacedError
from analysis.balls.films.film import Film, FilmHead
from analysis.balls.films.part import Cut, PartOfFilm
from analysis.balls.films.raw import RawLayout
from analysis.balls.films.reading import open_film
from analysis.balls.films.steady import ShakenError, SteadyFilm
from analysis.balls.flight.flights import MOST_UNSURE_FALL
from analysis.balls.flight.known import Ball
from analysis.balls.lens.lens import Lens, StraightFilm
from analysis.balls.looking import Looked, TurnedLook
from analysis.balls.measuring import MeasuredBall, measure_ball
from analysis.balls.remarks import remarks
from analysis.balls.seen.left_out import ThinnedError
from analysis.balls.seen.repeats import BroughtToRateError
from analysis.errors import ShotRefusedError

TURNS = {2: "stands upside down", 1: "lies on its side", 3: "lies on its side"}
"""Quarter turns that may put a film upright, and what is wrong with it."""


@dataclass(frozen=True, slots=True)
class FilmJob:
    """One film to be analysed.

    Attributes
    ----------
    shot
        Its number.
    path
        File or folder.
    ball
        What is stated of the ball.
    rate_hz
        Frames a second, where stated; else the file's own.
    exposure_s
        Where stated; else the file's own, or what the smear shows.
    cut
        Part of the film to look at; None: all of it.
    lens
        Its distortion is taken out of the pictures; None: they are taken as they are.
    raw
        Pictures of a film without a header.
    """

    shot: int
    path: Path
    ball: Ball
    rate_hz: float | None = None
    exposure_s: float | None = None
    cut: Cut | None = None
    lens: Lens | None = None
    raw: RawLayout | None = None


MOST_OFF = 0.3
"""Of places from the flights of their ball, rms, in radii: real films have 0.01 to 0.1."""
LEAST_FOLLOWED = 2 / 3
"""Of the frames from the first place to the last: those that have one."""


@dataclass(frozen=True, slots=True, eq=False)
class AnalysedFilm:
    """A measured ball, its film, and what a person should know."""

    film: Film
    measured: MeasuredBall
    notes: tuple[str, ...]


def analyse_film(job: FilmJob) -> AnalysedFilm:
    """Measure one film.

    Raises
    ------
    InputError
        The film cannot be read, or the lens is of pictures of another size.
    ShotRefusedError
        It has no times, or nothing in it is a ball in flight; `NotFlyingError` has the places of a
        ball that is seen and does not fly.
    """
    film: Film = open_film(job.path, job.raw)
    try:
        return _analysed(film, job)
    except InterlacedError:
        return _analysed(FieldsFilm(film), _of_fields(job))


def _of_fields(job: FilmJob) -> FilmJob:
    """Return the same job for a film's fields, two of which are in each frame."""
    cut, rate = job.cut, job.rate_hz
    if cut is not None:
        last = None if cut.last is None else 2 * cut.last
        cut = replace(cut, first=2 * cut.first, last=last)
    return replace(job, cut=cut, rate_hz=None if rate is None else 2 * rate)


def _analysed(film: Film, job: FilmJob) -> AnalysedFilm:
    whole = film.head
    if job.lens is not None:
        film = StraightFilm(film, job.lens)
    if job.cut is not None:
        film = PartOfFilm(film, job.cut)
    times = frame_times(film, job.rate_hz)
    exposure = job.exposure_s if job.exposure_s is not None else film.head.exposure_s
    found = analyse_held(film, times, job.ball, exposure)
    if job.cut is None:
        return found
    return replace(found, notes=(_cut_away(job.cut, whole), *found.notes))


def _cut_away(cut: Cut, head: FilmHead) -> str:
    """Say what of a film was not looked at, and from where frames and pixels count."""
    last = head.frames if cut.last is None else cut.last
    said = f"frames {cut.first} to {last - 1} of {head.frames} were looked at, as was asked"
    if cut.first:
        said += f"; frame numbers here count from frame {cut.first}"
    if cut.window is not None:
        x, y, w, h = cut.window
        said += (
            f"; of their pictures columns {x} to {x + w - 1} and rows {y} to {y + h - 1}, from "
            "whose corner pixels count"
        )
    return said


def analyse_held(film: Film, times: Floats, ball: Ball, exposure: float | None) -> AnalysedFilm:
    """Measure a film that is open, with the time of each frame in s.

    Raises
    ------
    ShotRefusedError
        Nothing in it is a ball in flight.
    """
    found = _held(film, times, ball, exposure)
    _refuse_no_flights(found.measured)
    return found


def _held(film: Film, times: Floats, ball: Ball, exposure: float | None) -> AnalysedFilm:
    """Measure an open film, whatever its flights leave of its places."""
    try:
        looked = Looked(film)
        measured = measure_ball(looked, times, ball, exposure)
    except ShakenError:
        steady = SteadyFilm(film)
        found = analyse_held(steady, times, ball, exposure)
        return replace(found, notes=(steady.note, *found.notes))
    except BroughtToRateError as brought:
        rhythm = brought.rhythm
        again = rhythm.repeats(film.head.frames)
        once = DistinctFilm(film, again, (rhythm.pictures, rhythm.frames), times)
        found = analyse_held(once, once.times_s, ball, exposure)
        return replace(found, notes=(once.note, *found.notes))
    except ThinnedError as thinned:
        found = analyse_held(film, thinned.times(times), ball, exposure)
        return replace(found, notes=(thinned.note(times), *found.notes))
    except (TurningError, OtherFallError) as refusal:
        refusal.placed = refusal.place(film)
        raise
    except ShotRefusedError as refusal:
        if refusal.step != "flight":
            raise
        ways = [way for way in TURNS if _may_fly(refusal, ball, way)]
        turned = _turned(looked, times, ball, exposure, ways)
        if turned is None:
            if isinstance(refusal, NotFlyingError):
                refusal.placed = refusal.place(film)
            raise
        return turned
    if measured.bounces == 0 and _seen_elsewhere(measured):
        turned = _turned(looked, times, ball, exposure, TURNS)
        if turned is not None and turned.measured.bounces:
            return turned
    even = _in_one_rate(film, measured, (times, ball, exposure)) if in_doubt(measured) else None
    return even or AnalysedFilm(film, measured, remarks(measured))


def _refuse_no_flights(measured: MeasuredBall) -> None:
    """Refuse places that lie off all flights and are few between the first and the last of them.

    Hands throw and catch balls, and several balls that are taken for one are seen now and then. A
    ball that is followed through all frames lies off its flights where the film's times are wrong.

    Raises
    ------
    ShotRefusedError
        With the frames, and how far off places are.
    """
    off = _off_flights(measured)
    if not math.isfinite(off):
        return
    # A flight between two surfaces belongs to both.
    frames = np.unique(np.concatenate([each.observed.frames for _, each in measured.surfaces]))
    first, last = int(frames[0]), int(frames[-1])
    if off < MOST_OFF or len(frames) > LEAST_FOLLOWED * (last - first + 1):
        return
    raise ShotRefusedError(
        "flight",
        f"what looks like the ball is seen in {len(frames)} of the frames {first} to {last}, and "
        f"there lies {off:.2g} of its radius off free flights that bounce, root mean square: hands "
        "move it, or several balls are taken for one; state a part of the film with one ball in "
        "flight (--frames, --roi)",
    )


def _off_flights(measured: MeasuredBall) -> float:
    """Return how far places lie off the flights that they fit best, root mean square, in radii."""
    return min(
        (
            float(np.std(flights.residuals[flights.used], axis=0).max()) / measured.looks.radius_px
            for _, flights in measured.surfaces
        ),
        default=math.inf,
    )


def _in_one_rate(
    film: Film, measured: MeasuredBall, asked: tuple[Floats, Ball, float | None]
) -> AnalysedFilm | None:
    """Measure the longest stretch of a film in which its rate holds; None where that tells no more.

    Parameters
    ----------
    asked
        Times of the frames, the ball and the exposure, as of the whole film.
    """
    times, ball, exposure = asked
    stretches = even_stretches(measured, times, ball)
    for first, last in stretches:
        if last - first + 1 == film.head.frames or _flown(measured) == (first, last):
            continue
        part = PartOfFilm(film, Cut(first, last + 1))
        try:
            own = measure_ball(Looked(part), times[first : last + 1] - times[first], ball, exposure)
        except ShotRefusedError:
            continue
        if in_doubt(own) or sure_bounces(own) <= sure_bounces(measured):
            continue
        others = [f"{a} to {b}" for a, b in stretches if (a, b) != (first, last)]
        said = (
            "the film's rate varies, or frames are missing, and its times do not say so: frames "
            f"{first} to {last}, in which its rate holds, were measured, and frame numbers here "
            f"count from frame {first}"
        )
        if others:
            said += f"; as even are frames {', '.join(others)} (--frames)"
        return AnalysedFilm(part, own, (said, *remarks(own)))
    return None


def _flown(measured: MeasuredBall) -> tuple[int, int] | None:
    """Return the first and the last frame of flights that bounce; None where none do.

    A stretch of just these frames holds nothing that was not measured.
    """
    if measured.bounces == 0:
        return None
    arcs = measured.chain.arcs
    return int(arcs[0].frames[0]), int(arcs[-1].frames[-1])


def _falls(measured: MeasuredBall) -> bool:
    """Return whether flights are bent by gravity, by several of their errors."""
    return measured.flights is not None and measured.flights.scale_of_fall[1] < MOST_UNSURE_FALL


def _seen_elsewhere(measured: MeasuredBall) -> bool:
    """Return whether a ball is seen in more frames outside its one flight than in it."""
    flown = sum(len(arc.frames) for arc in measured.chain.arcs)
    return len(measured.search.unexplained) > flown


def _may_fly(refusal: ShotRefusedError, ball: Ball, turns: int) -> bool:
    """Return whether a film that was refused may hold a flight once its pictures are turned.

    What was seen of balls in it says so without reading it again.
    """
    return not isinstance(refusal, CarriedError) or refusal.flies_turned(ball, turns)


def _turned(
    looked: Looked, times: Floats, ball: Ball, exposure: float | None, ways: Iterable[int]
) -> AnalysedFilm | None:
    """Measure a film in which things fall up or sideways; None where they fall no way.

    A way in which the ball bounces goes before one in which it only flies; one flight of fewer
    frames than those in which the ball is seen elsewhere is none: so a ball moves that is pushed.
    Nor does a ball fall whose flights leave gravity open: so one moves that rolls, by its scatter.
    Nor one whose places lie far off its flights: upside down, hands seem to throw balls down.

    Parameters
    ----------
    ways
        Quarter turns that are tried.
    """
    found: AnalysedFilm | None = None
    for turns in ways:
        upright = TurnedLook(looked, turns)
        try:
            measured = measure_ball(upright, times, ball, exposure)
        except ShotRefusedError:
            continue
        if measured.bounces == 0 and _seen_elsewhere(measured):
            continue
        if not _falls(measured) or (measured.bounces and _off_flights(measured) > MOST_OFF):
            continue
        note = f"the film {TURNS[turns]}: rows and columns are those of the picture turned upright"
        if found is None or measured.bounces:
            found = AnalysedFilm(upright.film, measured, (note, *remarks(measured)))
        if measured.bounces:
            break
    return found


def frame_times(film: Film, rate_hz: float | None) -> Floats:
    """Return the time of each frame, s.

    A stated rate holds for all frames: it is that of the camera, where the file's is that of the
    player.

    Raises
    ------
    ShotRefusedError
        Neither the file nor a person says.
    """
    head = film.head
    if rate_hz is not None:
        return np.asarray(np.arange(head.frames) / rate_hz)
    if head.times_s is not None:
        return head.times_s
    if head.rate_hz is not None:
        return np.asarray(np.arange(head.frames) / head.rate_hz)
    raise ShotRefusedError("frames", "the file says no frame rate; state it with --fps")
