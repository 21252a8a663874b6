"""Physical limits on free flights and the contact between them; refusals with the reason."""

from __future__ import annotations

import numpy as np

from analysis.collision.coefficients import Impact
from analysis.collision.instant import NoTouchError
from analysis.errors import NoContactError, ShotRefusedError
from analysis.motion.split import LEAST_FRAMES
from analysis.motion.velocity import FlightPath
from analysis.shot_poses import Frames, ShotPoses
from analysis.sides import Side

MISMATCH_FRAMES = 1.5
LEAST_OF_A_COORDINATE = 2
IMPOSSIBLE_SIGMAS, LEAST_BEYOND = 5.0, 0.02
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


def check_seen(poses: ShotPoses, side: Side, sphere: int) -> None:
    """Refuse where too few frames show a coordinate."""
    seen = np.isfinite(poses.position_sigma[side.rows, sphere]).sum(axis=0)
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
