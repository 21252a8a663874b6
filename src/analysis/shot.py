"""The whole way of one shot, from frames to coefficients (thesis, appendix C)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from analysis.arrays import Floats, Grey
from analysis.collision.coefficients import Impact
from analysis.collision.operator import Body
from analysis.errors import NoContactError, ShotRefusedError
from analysis.imaging.edge.frame import EdgeSettings
from analysis.imaging.stated_view import first_row, stated_view
from analysis.motion.frame_notes import gathered
from analysis.motion.pattern import Orientations
from analysis.motion.poses import Centres
from analysis.refusals import what_happened
from analysis.scene import Scene
from analysis.setup import NO_SLOW_ERRORS, Setup, SlowErrors
from analysis.shot_poses import ShotPoses
from analysis.slow_errors import slow_errors
from analysis.tracking import Matching, Tracking, track_spheres
from analysis.two_sides import TwoSides, measure_two_sides

if TYPE_CHECKING:
    from analysis.photometric.learn.appearance import Appearance


ASTRAY = "it contradicts those of the other frames on its side of the contact"

FALSE_SPINS = (
    "their change at the contact contradicts the impulse that velocities or the other sphere's "
    "spins show, so that the few markers that are known of it are seen in a wrong turn; more "
    "training shots, or markers, help"
)


def measuring_notes(tracking: Tracking, setup: Setup, sides: TwoSides) -> tuple[str, ...]:
    """Return what did not count: frames, outlines, orientations, spins; a sentence a reason."""
    sure = setup.camera.exposure_s is not None
    why = "exposed" if sure else "perhaps exposed, as no exposure is stated,"
    notes = [f"frame {k} left out: {why} during the contact" for k in sides.between]
    notes += [
        f"frame {k} left out for sphere {name}: off its free flight" for name, k in sides.wild
    ]
    for name, k in sides.astray:
        notes.append(f"frame {k} has no orientation of sphere {name}: {ASTRAY}")
    for name, sphere in zip("ab", tracking.spheres, strict=True):
        for view, track in sphere.items():
            followed = range(min(track.outlines), max(track.outlines) + 1)
            gaps = [k for k in followed if k not in track.outlines]
            notes += [
                f"frame {k} shows no outline of sphere {name} in the {view.value} view"
                for k in gaps
            ]
    for name, orientations in zip("ab", tracking.orientations, strict=True):
        for k, reason in sorted(orientations.left_out.items()):
            notes.append(f"frame {k} has no orientation of sphere {name}: {reason}")
    notes += sides.heights
    notes += [f"no spins of sphere {name}: {FALSE_SPINS}" for name in sides.false_spins]
    if not sides.false_spins and sides.impact.v_s is None:
        notes.append("no surface velocities: too few orientations tell the spins")
    return tuple(gathered(notes))


Method = Literal["thesis", "photometric"]

LEAST_FRAMES = 6
RATE_TOLERANCE = 0.01


@dataclass(frozen=True, slots=True)
class AnalysisOptions:
    """How a shot is analysed.

    Attributes
    ----------
    edges
        Filter and subpixel method of "thesis"; None: the defaults.
    matching
        Of "thesis": "pattern" matches every frame against one body pattern by rigid rotation, both
        views together; "proximal" goes from frame to frame in the front view (appendix B). None:
        "pattern".
    three_and_three
        Use the thesis's three frames before and three after contact, 2 ms apart, with its
        equations (5-1) to (5-4) and (5-32), (5-33); otherwise all frames by least squares.
    method
        "photometric" fits a rendered sphere to every pixel (docs/explanation/photometric.md);
        "thesis" finds outlines and markers by their edges.

    Raises
    ------
    ValueError
        Edges or matching for "photometric", which has neither.
    """

    edges: EdgeSettings | None = None
    matching: Matching | None = None
    three_and_three: bool = False
    method: Method = "photometric"

    def __post_init__(self) -> None:
        if self.method != "thesis" and (self.edges is not None or self.matching is not None):
            raise ValueError(f"edges and matching mean nothing to the {self.method} method")


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredShot:
    """A shot with its collision.

    Attributes
    ----------
    impact
        Velocities, coefficients and their errors.
    centres, orientations
        Poses of a and b.
    tracking
        Outlines and markers behind the poses.
    times_s
        Time of each frame, s from the first, shape (frames,).
    used_before, used_after
        Frames on either side of the contact that entered the fit.
    between
        Frames that were exposed during the contact and show neither side.
    notes
        What was left out, and why.
    bodies
        What collided.
    known
        What the photometric method has learned of the spheres; it serves the next shot.
    slow
        How the poses err beside their scatter.
    """

    impact: Impact
    centres: tuple[Centres, Centres]
    orientations: tuple[Orientations, Orientations]
    tracking: Tracking
    times_s: Floats
    used_before: tuple[int, ...]
    used_after: tuple[int, ...]
    between: tuple[int, ...]
    notes: tuple[str, ...]
    bodies: tuple[Body, Body]
    known: Appearance | None = None
    slow: SlowErrors = NO_SLOW_ERRORS


@dataclass(frozen=True, slots=True)
class RefusedShot:
    """A shot that cannot be analysed, with the reason; false in a condition.

    Attributes
    ----------
    discs
        Row, column and radius of what was found in the frame, pixels, before spheres were followed.
    tracking
        Outlines and markers, where the spheres were followed and their paths are refused.
    """

    step: str
    reason: str
    frame: int | None
    discs: tuple[tuple[float, float, float], ...] = ()
    tracking: Tracking | None = None

    def __bool__(self) -> bool:
        return False


def analyse_shot(
    frames: Grey,
    times_s: Floats,
    setup: Setup,
    options: AnalysisOptions | None = None,
    known: Appearance | None = None,
    *,
    extend: bool = False,
) -> MeasuredShot | RefusedShot:
    """Measure the collision in the frames of one shot.

    Parameters
    ----------
    frames
        Grey levels on the scale of 8 bits, shape (frames, rows, columns), at least 6.
    times_s
        Time of each frame, s, increasing from any start, shape (frames,).
    setup
        Camera, spheres and surroundings.
    known
        What an earlier shot of the same spheres and camera has taught the photometric method.
    extend
        Let this shot add to it: markers on a side of a sphere that no shot has shown before.

    Returns
    -------
    The measured shot, or a refusal with the step that failed, the frame and the reason. Nothing
    is guessed and nothing is raised for what the frames hold.
    """
    chosen, above = options or AnalysisOptions(), first_row(setup.camera)
    try:
        check_frames(frames, times_s, setup)
        frames, setup = stated_view(frames, setup)
    except ShotRefusedError as refusal:
        return _refused(refusal, None, above)
    film = frames, times_s - times_s[0], above
    found = _measured(film, setup, chosen, known, extend=extend)
    if chosen.method == "thesis":
        return found
    learned_alone = known is None or found.tracking is None or found.tracking.learned_alone
    if isinstance(found, RefusedShot) and not learned_alone:
        # What others have taught may be wrong of this side of a sphere; the film may show more.
        alone = _measured(film, setup, chosen, None, unlike=found.reason)
        found = alone if isinstance(alone, MeasuredShot) else found
    if not (turnless := _turnless(found)):
        return found
    # Markers that tell no turn were learned wrong, and places by them bend a flight.
    outlined = _measured(film, setup, chosen, known, turnless=turnless)
    return outlined if _surer(outlined, found) else found


MOSTLY = 0.5
"""Share of a sphere's frames without an orientation beyond which its markers tell no turn."""
BY_MARKERS = {"assignment", "motion", "contact"}
"""Steps at which markers are followed: those of spheres that turn far are lost or mistaken."""


def _turnless(found: MeasuredShot | RefusedShot) -> str:
    """Return why markers do not tell how the spheres turn; nothing where they do."""
    tracking = found.tracking
    if tracking is not None and not any(len(own.frames) for own in tracking.orientations):
        return ""  # Outlines alone have measured it.
    if isinstance(found, RefusedShot) and found.step in BY_MARKERS:
        return f"by its markers the shot is refused: {found.reason}"
    if tracking is None:  # Refused before any was found.
        return ""
    for name, turned, seen in zip("ab", tracking.orientations, tracking.centres, strict=True):
        if len(turned.frames) < MOSTLY * len(seen.frames):
            told = f"{len(turned.frames)} of the {len(seen.frames)} frames"
            return f"the markers of sphere {name} tell how it is turned in {told} that show it"
    return ""


def _surer(one: MeasuredShot | RefusedShot, other: MeasuredShot | RefusedShot) -> bool:
    """Whether one way measures the restitution with a smaller error than the other does."""
    if isinstance(one, RefusedShot) or isinstance(other, RefusedShot):
        return isinstance(one, MeasuredShot)
    return one.impact.e.sigma < other.impact.e.sigma


def _measured(
    film: tuple[Grey, Floats, int],
    setup: Setup,
    chosen: AnalysisOptions,
    known: Appearance | None,
    *,
    extend: bool = False,
    unlike: str = "",
    turnless: str = "",
) -> MeasuredShot | RefusedShot:
    """Measure a film in the stated view.

    Parameters
    ----------
    film
        Frames, their times from the first, and the row of the whole picture that theirs begin at.
    unlike
        Why a shot is learned by itself where others are known.
    turnless
        Why a shot is measured by its outlines alone.
    """
    frames, elapsed_s, above = film
    tracking = None
    try:
        if chosen.method == "thesis":
            edges, matching = chosen.edges or EdgeSettings(), chosen.matching or "pattern"
            tracking = track_spheres(frames, elapsed_s, setup, edges, matching)
            known = None
        elif turnless:
            tracking = _outlined(frames, elapsed_s, setup, turnless)
        else:
            tracking, known = _rendered(
                frames, elapsed_s, setup, known, extend=extend, unlike=unlike
            )
        one_body_frame = known is not None and not tracking.learned_alone
        slow = slow_errors(tracking, setup, one_body_frame=one_body_frame)
        poses = ShotPoses.of_tracks(tracking.centres, tracking.orientations, elapsed_s)
        scene = Scene.of(setup, slow, float(np.median(np.diff(elapsed_s))))
        sides = measure_two_sides(poses, scene, three_and_three=chosen.three_and_three)
    except NoContactError as refusal:
        happened = "" if tracking is None else what_happened(tracking, setup, elapsed_s)
        return _refused(refusal, tracking, above, happened)
    except ShotRefusedError as refusal:
        return _refused(refusal, tracking, above)
    return MeasuredShot(
        impact=sides.impact,
        bodies=scene.bodies,
        centres=tracking.centres,
        orientations=tracking.orientations,
        tracking=tracking.lowered(above),
        times_s=elapsed_s,
        used_before=sides.used_before,
        used_after=sides.used_after,
        between=sides.between,
        notes=(
            *tracking.notes,
            *measuring_notes(tracking, setup, sides),
            *_odd_times(elapsed_s, setup),
        ),
        known=known,
        slow=slow,
    )


def _refused(
    refusal: ShotRefusedError, tracking: Tracking | None, above: int, happened: str = ""
) -> RefusedShot:
    """Return a refusal in pixels of the whole frame, of which so many rows were not looked at."""
    reason = f"{happened} ({refusal.reason})" if happened else refusal.reason
    discs = tuple((row + above, column, radius) for row, column, radius in refusal.discs)
    if discs:
        places = ", ".join(f"({row:.0f}, {column:.0f})" for row, column, _ in discs)
        reason += f", at (row, column) {places}"
    shown = None if tracking is None else tracking.lowered(above)
    return RefusedShot(refusal.step, reason, refusal.frame, discs, shown)


def _rendered(
    frames: Grey,
    elapsed_s: Floats,
    setup: Setup,
    known: Appearance | None,
    *,
    extend: bool,
    unlike: str,
) -> tuple[Tracking, Appearance | None]:
    """Return poses by the photometric method; of spheres without markers, places by outlines."""
    # Loading compiled functions is slow; the thesis method needs none of these.
    from analysis.photometric.method import measure_poses  # noqa: PLC0415

    try:
        return measure_poses(frames, elapsed_s, setup, known, extend=extend, unlike=unlike)
    except ShotRefusedError as refusal:
        if refusal.step != "markers":
            raise
        return _outlined(frames, elapsed_s, setup, refusal.reason), known


def _outlined(frames: Grey, elapsed_s: Floats, setup: Setup, reason: str) -> Tracking:
    """Return places by outlines alone, and why no orientation is known."""
    from analysis.photometric.follow.first_tracking import track_unmarked  # noqa: PLC0415

    return track_unmarked(frames, elapsed_s, setup, reason)


def _odd_times(times_s: Floats, setup: Setup) -> tuple[str, ...]:
    """Return a note where the frames' own times and the stated rate disagree; times are used."""
    step = float(np.median(np.diff(times_s)))
    if abs(step * setup.camera.frame_rate_hz - 1.0) < RATE_TOLERANCE:
        return ()
    return (
        f"frames are {1e3 * step:.4g} ms apart by the times that come with them, "
        f"{1e3 / setup.camera.frame_rate_hz:.4g} ms by the stated frame rate; the times are used",
    )


def check_frames(frames: Grey, times_s: Floats, setup: Setup) -> None:
    """Refuse frames of the wrong depth, size or count, or without increasing times.

    Raises
    ------
    ShotRefusedError
        With what was found and what is needed.
    """
    expected = (setup.camera.height_px, setup.camera.width_px)
    if frames.ndim != 3 or frames.dtype not in {np.dtype(np.uint8), np.dtype(np.float32)}:
        raise ShotRefusedError(
            "frames",
            f"a stack of shape {frames.shape} and type {frames.dtype}; grey frames "
            "(frames, rows, columns) are needed",
        )
    if frames.shape[1:] != expected:
        raise ShotRefusedError(
            "frames",
            f"frames of {frames.shape[1]} x {frames.shape[2]} pixels (rows x columns); the camera "
            f"is set up for {expected[0]} x {expected[1]}",
        )
    if len(frames) < LEAST_FRAMES:
        raise ShotRefusedError(
            "frames", f"{len(frames)} frames; at least {LEAST_FRAMES} are needed"
        )
    if times_s.shape != (len(frames),):
        raise ShotRefusedError("frames", f"{times_s.size} times for {len(frames)} frames")
    steps = np.diff(times_s)
    if not (np.isfinite(times_s).all() and (steps > 0).all()):
        bad = int(np.argmax(~(steps > 0))) + 1
        raise ShotRefusedError("frames", "the time does not increase from the frame before", bad)
