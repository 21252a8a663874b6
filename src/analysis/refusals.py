"""Why a shot has no coefficients: limits of free flights and of the contact, and what happened.

A shot without a contact is refused for what its tracks lack. What a person can mend is what
happened: a sphere that leaves the stated view, spheres that pass each other, a film that ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import Floats
from analysis.collision.coefficients import Impact
from analysis.collision.instant import NoTouchError, touching_time
from analysis.collision.operator import Body
from analysis.errors import NoContactError, ShotRefusedError
from analysis.imaging.views import ViewGeometry, view_geometries
from analysis.motion.split import LEAST_FRAMES
from analysis.motion.velocity import DOWN, FlightPath
from analysis.setup import Setup
from analysis.shot_poses import Frames, ShotPoses
from analysis.sides import Side

if TYPE_CHECKING:
    from analysis.imaging.tracks import Track
    from analysis.motion.poses import Centres
    from analysis.tracking import Tracking


MISMATCH_FRAMES = 1.5
LEAST_OF_A_COORDINATE = 2
IMPOSSIBLE_SIGMAS, LEAST_BEYOND = 5.0, 0.02
LEAST_TOGETHER, MOST_OFF = 3, 0.05
"""Frames with both spheres, and how far their places lie off free flight, over both radii."""
MOST_UNLIKE = 0.05
"""Sine of the angle between one change of velocity and the opposite of the other, at least."""
FILMS_OFF = 4.0
"""Lengths of the film in which what moves would have met."""
_VIEWS = ("front", "front", "top")


def never_meet(miss: NoTouchError, radii: tuple[float, float]) -> NoContactError:
    """Return the refusal of paths that pass each other by."""
    return NoContactError(
        "contact",
        f"the paths before the kink pass at {1e3 * miss.closest_m:.2f} mm between the centres; "
        f"the spheres touch at {1e3 * sum(radii):.2f} mm",
    )


def check_between(contact: float, poses: ShotPoses, before: Frames, after: Frames) -> None:
    """Refuse where the touch lies far from the kink: then one of the two is wrong."""
    times_s = poses.times_s
    step = float(np.median(np.diff(times_s)))
    early = times_s[before[-1]] - MISMATCH_FRAMES * step
    late = times_s[after[0]] + MISMATCH_FRAMES * step
    if not times_s[0] - step <= contact <= times_s[-1] + step:
        raise ShotRefusedError(
            "contact",
            f"the paths touch {1e3 * contact:.1f} ms from the first frame, outside the film: what "
            "was followed may be something else than the spheres; check their contrast, the "
            "diameters and the scale",
        )
    if not early <= contact <= late:
        raise ShotRefusedError(
            "contact",
            f"the paths touch at {1e3 * contact:.2f} ms but have their kink between "
            f"{1e3 * times_s[before[-1]]:.2f} and {1e3 * times_s[after[0]]:.2f} ms; check the "
            "diameters and the scale",
            int(poses.frames[after[0]]),
        )


def check_parting(impact: Impact, poses: ShotPoses, before: Frames, after: Frames) -> None:
    """Refuse where the paths after the contact part far from the kink: then they are wrong."""
    if impact.duration is None:
        return
    times_s, allowed = poses.times_s, IMPOSSIBLE_SIGMAS * impact.duration.sigma
    parting = impact.contact_time.value + impact.duration.value
    allowed += MISMATCH_FRAMES * float(np.median(np.diff(times_s)))
    if times_s[before[-1]] - allowed <= parting <= times_s[after[0]] + allowed:
        return
    raise ShotRefusedError(
        "contact",
        f"the spheres touch at {1e3 * impact.contact_time.value:.2f} ms and by their paths after "
        f"it part at {1e3 * parting:.2f} ms, but the film shows them apart from "
        f"{1e3 * times_s[after[0]]:.2f} ms on; one of the tracks after the contact is wrong: look "
        "at the film, and for something that looks like a sphere",
        int(poses.frames[after[0]]),
    )


def check_enough(poses: ShotPoses, side: Side, sphere: int | None) -> None:
    """Refuse too few frames on a side, of a sphere or of both together."""
    clear, whose = len(side.rows), ""
    if sphere is not None:
        clear = int(np.isfinite(poses.position_sigma[side.rows, sphere]).any(axis=1).sum())
        whose = f" of sphere {'ab'[sphere]}"
    if clear < LEAST_FRAMES:
        raise NoContactError(
            "contact",
            f"{clear} frames{whose} clear of the contact {side.word} it; {LEAST_FRAMES} are needed",
            None if side.rows.size == 0 else int(poses.frames[side.rows[0]]),
        )


def check_seen(poses: ShotPoses, side: Side, sphere: int, axes: Sequence[str] = "XYZ") -> None:
    """Refuse where too few frames show one of the first coordinates."""
    seen = np.isfinite(poses.position_sigma[side.rows, sphere, : len(axes)]).sum(axis=0)
    axis = int(seen.argmin())
    if seen[axis] < LEAST_OF_A_COORDINATE:
        raise ShotRefusedError(
            "outlines",
            f"the {_VIEWS[axis]} view shows sphere {'ab'[sphere]} in {seen[axis]} of the "
            f"{len(side.rows)} frames {side.word} the contact; {LEAST_OF_A_COORDINATE} are needed "
            f"for its {'XYZ'[axis]}",
            int(poses.frames[side.rows[0]]),
        )


def check_free_flight(
    poses: ShotPoses, side: Side, sphere: int, path: FlightPath, most_chi2: float
) -> None:
    """Refuse a track that jumps: a frame is lost, repeated or out of order, or the disc was."""
    if not path.chi2_per_dof > most_chi2:
        return
    times = poses.times_s[side.rows]
    fitted = np.array([path.at(float(t))[0] for t in times])
    off = np.abs(poses.position[side.rows, sphere] - fitted)
    worst = int((off / poses.position_sigma[side.rows, sphere]).max(axis=1).argmax())
    raise ShotRefusedError(
        "motion",
        f"the track of sphere {'ab'[sphere]} {side.word} the contact is no free flight: "
        f"chi-squared {path.chi2_per_dof:.0f} per degree of freedom, {most_chi2:g} allowed; "
        "look for lost, repeated or exchanged frames",
        int(poses.frames[side.rows[worst]]),
    )


def check_possible(impact: Impact) -> None:
    """Refuse what no passive contact can do: gain energy along or across the normal."""
    for name, ratio, least in (("e", impact.e, 0.0), ("beta", impact.beta, -1.0)):
        if ratio is None:
            continue
        beyond = max(ratio.value - 1.0, least - ratio.value)
        if beyond > max(IMPOSSIBLE_SIGMAS * ratio.sigma, LEAST_BEYOND):
            raise ShotRefusedError(
                "contact",
                f"{name} = {ratio.concise()} lies outside {least:g} to 1, which no contact can; "
                "check the order of the frames and the orientation of the images",
            )


def check_opposite(impact: Impact, bodies: tuple[Body, Body], *, depth_seen: bool) -> None:
    """Refuse velocities whose changes are not opposite: one impulse changes both.

    That holds for any masses, m_a dv_a = -m_b dv_b, and any law of contact. With a plate there is
    no second change; where depth is not seen, only the changes across the view count.
    """
    if any(body.is_plate for body in bodies):
        return
    before, after = impact.before, impact.after
    a, b = after.velocity_a - before.velocity_a, after.velocity_b - before.velocity_b
    sigma_a, sigma_b = np.linalg.norm(impact.state_sigma[:, :2], axis=0)
    axes = slice(3 if depth_seen else 2)
    ratio = -float(a[axes] @ b[axes]) / max(float(b[axes] @ b[axes]), np.finfo(np.float64).tiny)
    off = (a + ratio * b)[axes]
    sigma = np.hypot(sigma_a, ratio * sigma_b)[axes]
    k = int(np.argmax(np.abs(off) - IMPOSSIBLE_SIGMAS * sigma))
    allowed = max(IMPOSSIBLE_SIGMAS * float(sigma[k]), MOST_UNLIKE * float(np.linalg.norm(a[axes])))
    if abs(off[k]) > allowed:
        raise ShotRefusedError(
            "motion",
            f"the changes of both velocities are not opposite: along {'XYZ'[k]} they are "
            f"{abs(off[k]):.3f} m/s apart, {allowed:.3f} m/s are allowed; one of the tracks is "
            "wrong, a sphere met something else, or times are not as stated: look at the film",
        )


def what_happened(tracking: Tracking, setup: Setup, times_s: Floats) -> str:
    """Return what the tracks show, empty where they show nothing of it.

    Parameters
    ----------
    setup
        Of the frames that were followed.
    times_s
        From the first frame, shape (F,).
    """
    said = [*_leaving(tracking, setup, len(times_s)), *_meeting(tracking, setup, times_s)]
    return "; ".join(said)


def _leaving(tracking: Tracking, setup: Setup, frames: int) -> Iterator[str]:
    """Say which sphere's track ends at an edge of a view, and after which frame."""
    for name, sphere in zip("ab", tracking.spheres, strict=True):
        for geometry in view_geometries(setup.camera):
            track = sphere.get(geometry.view)
            if track is None or len(track.outlines) < 2 or max(track.outlines) >= frames - 1:
                continue
            edge = _crossed(track, geometry, setup.camera.width_px)
            if edge is not None:
                view, last = geometry.view.value, max(track.outlines)
                yield f"sphere {name} crosses the {edge} edge of the {view} view after frame {last}"
                break


def _crossed(track: Track, geometry: ViewGeometry, width_px: int) -> str | None:
    """Return the edge that a disc crosses in the frame after its last; None for none."""
    before, last = sorted(track.outlines)[-2:]
    first, second = track.outlines[before].circle, track.outlines[last].circle
    row = second.row + (second.row - first.row) / (last - before)
    column = second.column + (second.column - first.column) / (last - before)
    beyond = {
        "upper": geometry.rows[0] - (row - second.radius),
        "lower": row + second.radius - geometry.rows[1],
        "left": second.radius - column,
        "right": column + second.radius - width_px,
    }
    edge = max(beyond, key=lambda name: beyond[name])
    return edge if beyond[edge] > 0.0 else None


def _meeting(tracking: Tracking, setup: Setup, times_s: Floats) -> Iterator[str]:
    """Say whether the free flights that the tracks show meet, where, and when."""
    reach = setup.spheres[0].diameter_m / 2 + setup.spheres[1].diameter_m / 2
    lines = _lines(tracking.centres, times_s, setup.environment.gravity_m_per_s2, reach)
    if lines is None:
        return
    apart, relative, seen = lines
    wait = float(touching_time(apart[None], relative[None], np.array(reach))[0])
    nearest = -float(apart @ relative) / float(relative @ relative)
    if abs(nearest if math.isnan(wait) else wait) > FILMS_OFF * (times_s[-1] - times_s[0]):
        # What hardly moves in the whole film is no sphere that was fired.
        return
    if nearest < times_s[seen[0]] - times_s[seen[-1]]:
        yield (
            f"the spheres part already in frame {seen[0]}, the first that shows both: a contact "
            "would lie before it"
        )
    elif math.isnan(wait):
        closest = float(np.linalg.norm(apart + relative * nearest))
        yield (
            f"the spheres pass each other with {1e3 * (closest - reach):.2f} mm between them, "
            f"nearest {_when(nearest, seen, times_s)} ({1e3 * closest:.2f} mm between their "
            f"centres, they touch at {1e3 * reach:.2f} mm)"
        )
    elif wait > 0.0:
        yield f"the spheres would touch {_when(wait, seen, times_s)}"


def _when(since_s: float, seen: Frames, times_s: Floats) -> str:
    at = float(times_s[int(seen[-1])]) + since_s
    if at > times_s[-1]:
        return f"{1e3 * (at - times_s[-1]):.1f} ms after the last frame of the film"
    return f"in frame {int(np.abs(times_s - at).argmin())}"


def _lines(
    centres: tuple[Centres, Centres], times_s: Floats, gravity: float, reach: float
) -> tuple[Floats, Floats, Frames] | None:
    """Return where b is from a in the last frame that shows both, its velocity, and those frames.

    By straight lines through the frames that show both, gravity taken out; None for too few, or
    where they are no straight lines.
    """
    seen = np.intersect1d(centres[0].frames, centres[1].frames)
    if len(seen) < LEAST_TOGETHER:
        return None
    tau = times_s[seen] - times_s[seen[-1]]
    states = []
    for own in centres:
        places = own.position[np.isin(own.frames, seen)]
        straight = np.nan_to_num(places) - 0.5 * gravity * DOWN * tau[:, None] ** 2
        speed, place = np.polyfit(tau, straight, 1)
        off = straight - place - tau[:, None] * speed
        if np.sqrt((off**2).sum(axis=1).mean()) > MOST_OFF * reach:
            return None
        states.append((place, speed))
    (place_a, speed_a), (place_b, speed_b) = states
    return place_b - place_a, speed_b - speed_a, seen
