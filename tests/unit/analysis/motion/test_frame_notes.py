"""What an analysis left out is named once for all frames that have the same reason."""

from __future__ import annotations

from analysis.motion.frame_notes import gathered

DIM = "no orientation of sphere a: only 2 markers in common with the frames before, 3 are needed"


def test_frames_with_the_same_reason_are_one_note_and_no_reason_is_lost() -> None:
    notes = [
        "frame 84 shows no outline of sphere b in the front view",
        "frame 17 has no orientation of sphere a: only 0 markers in common",
        f"frame 111 has {DIM}",
        "the stated rate and the times of the frames disagree",
        f"frame 112 has {DIM}",
        f"frame 113 has {DIM}",
        f"frame 119 has {DIM}",
        "frame 85 shows no outline of sphere b in the front view",
    ]
    assert gathered(notes) == [
        "frames 84–85 show no outline of sphere b in the front view",
        "frame 17 has no orientation of sphere a: only 0 markers in common",
        f"frames 111–113, 119 have {DIM}",
        "the stated rate and the times of the frames disagree",
    ]
    wild = [f"frame {k} left out for sphere a: off its free flight" for k in (40, 41, 42)]
    assert gathered([*wild, "frame 53 left out: exposed during the contact"]) == [
        "frames 40–42 left out for sphere a: off its free flight",
        "frame 53 left out: exposed during the contact",
    ]
    assert gathered([]) == []
