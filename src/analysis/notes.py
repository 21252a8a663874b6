"""What was left out of a shot's measurement, and why, in words."""

from __future__ import annotations

from analysis.setup import Setup
from analysis.tracking import Tracking
from analysis.two_sides import TwoSides


def measuring_notes(tracking: Tracking, setup: Setup, sides: TwoSides) -> tuple[str, ...]:
    """Return a sentence on each frame, outline, orientation or spin that did not count."""
    sure = setup.camera.exposure_s is not None
    why = "exposed" if sure else "perhaps exposed, as no exposure is stated,"
    notes = [f"frame {k} left out: {why} during the contact" for k in sides.between]
    notes += [
        f"frame {k} left out for sphere {name}: off its free flight" for name, k in sides.wild
    ]
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
    if sides.impact.v_s is None:
        notes.append("no surface velocities: too few orientations tell the spins")
    return tuple(notes)
