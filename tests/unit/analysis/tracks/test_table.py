"""Tables of trackers: places, frames and times are those that were written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.balls.tracks.table import TrackTable, read_track_table
from analysis.errors import InputError

TRACKER = "mass A\t\t\nt (s)\tx (cm)\ty (cm)\n0,0\t1,5\t2,5E1\n4,0E-2\t1,6\t2,4E1\n"
MTRACK = (
    "Frame,X1,Y1,Flag1,X2,Y2,Flag2\nTracks,1,to,2,,,\n7,1.5,25,,,,\n8,1.6,24,*,9,9,\n"
    "Track,Length,Distance,,,,\n1,60.5,6.6,,,,\n"
)
MANUAL = (
    " \tTrack n\u00b0\tSlice n\u00b0\tX\tY\tDistance\n1\t1\t7\t1.5\t25\t-1\n2\t1\t8\t1.6\t24\t1.2\n"
)
TRACKMATE = (
    "LABEL,TRACK_ID,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME\n"
    "Label,Track ID,X,Y,Z,T,Frame\n,,X,Y,Z,T,Frame\n,,(micron),(micron),(micron),(sec),\n"
    "ID1,0,1.5,25,0,0.28,7\nID2,0,1.6,24,0,0.32,8\n"
)
TRACKPY = ",y,x,mass,frame,particle\n0,25,1.5,800,7.0,3.0\n1,24,1.6,801,8.0,3.0\n"
BLANK = "x;y\n1,5;25\n;\n\n1,6;24\n"
QUOTED = 'step,frame,x,y\n0,7,"1,5","25,0"\n1,8,"1,6","24,0"\n'
DLTDV = "pt1_cam1_X,pt1_cam1_Y\nNaN,NaN\n1.5,25\n1.6,24\n"
XM_YM = " ,Area,X,XM,Y,YM,Slice\n1,9,1.5,7,25,9,7\n2,9,1.6,7,24,9,8\n"
CENTROID = "frame,centroid_x,centroid_y\n7,1.5,25\n8,1.6,24\n"
OPENCV = "frame_idx,cx,cy,radius\n7,1.5,25,20\n8,1.6,24,20\n"
CAPSTONE = "Video: Time (s),Video: X (ft) Run #1,Video: Y (ft)\n0,1.5,25\n0.04,1.6,24\n"
KINOVEA = "#Kinovea Trajectory data export\n# T X Y\n0.0 1.5 25\n0.04 1.6 24\n"
CODED = "Time;X;Y\n0:00:00.000;1,5;25\n0:01:00.040;1,6;24\n"
MINUTES = "t (min),x (inch),y (inch)\n0,1.5,25\n1.5,1.6,24\n"
MIXED = "t (s),x (m),y (cm)\n0,1.5,2500\n0.04,1.6,2400\n"
SPACED = "t_ms x_mm y_mm\n280 1.5 25\n320 1.6 24\n"


@pytest.mark.parametrize(
    ("text", "frames", "times", "metres"),
    [
        pytest.param(TRACKER, [0, 1], [0.0, 0.04], 0.01, id="Tracker"),
        pytest.param(MANUAL, [7, 8], None, None, id="ImageJ's Manual Tracking"),
        pytest.param(TRACKMATE, [7, 8], [0.28, 0.32], 1e-6, id="TrackMate"),
        pytest.param(TRACKPY, [7, 8], None, None, id="trackpy"),
        pytest.param(BLANK, [0, 3], None, None, id="rows of lost frames"),
        pytest.param(
            QUOTED, [7, 8], None, None, id="quoted decimal commas and two kinds of frames"
        ),
        pytest.param(DLTDV, [1, 2], None, None, id="DLTdv"),
        pytest.param(XM_YM, [7, 8], None, None, id="ImageJ's Results with two kinds of places"),
        pytest.param(
            XM_YM.replace("X,XM,Y,YM", "XM,A,YM,B"), [7, 8], None, None, id="its centres of mass"
        ),
        pytest.param(CENTROID, [7, 8], None, None, id="centroids"),
        pytest.param(OPENCV, [7, 8], None, None, id="OpenCV"),
        pytest.param(CAPSTONE, [0, 1], [0.0, 0.04], 0.3048, id="Logger Pro and Capstone"),
        pytest.param(KINOVEA, [0, 1], [0.0, 0.04], None, id="names in a comment"),
        pytest.param(CODED, [0, 1], [0.0, 60.04], None, id="time codes"),
        pytest.param(MINUTES, [0, 1], [0.0, 90.0], 0.0254, id="minutes and inches"),
        pytest.param(SPACED, [0, 1], [0.28, 0.32], 1e-3, id="columns by name"),
    ],
)
def test_a_table_gives_the_places_frames_and_times_that_its_program_wrote(
    text: str,
    frames: list[int],
    times: list[float] | None,
    metres: float | None,
    tmp_path: Path,
) -> None:
    path = tmp_path / "table.csv"
    path.write_text(text, encoding="latin-1")
    table = read_track_table(path)
    assert table.places[:, :2].tolist() == [[1.5, 25.0], [1.6, 24.0]]
    assert table.frames.tolist() == frames
    assert (None if table.times_s is None else table.times_s.tolist()) == times
    assert table.metres == metres
    assert table.notes == ()


def read(tmp_path: Path, text: str) -> TrackTable:
    path = tmp_path / "table.csv"
    path.write_text(text)
    return read_track_table(path)


def test_axes_in_two_units_are_brought_to_one(tmp_path: Path) -> None:
    table = read(tmp_path, MIXED)
    assert table.places == pytest.approx(np.array([[1.5, 25.0], [1.6, 24.0]]))
    assert table.metres == 1.0
    assert table.notes == ("axes in m and cm: all are brought to m",)


def test_a_unit_that_is_not_known_is_named(tmp_path: Path) -> None:
    table = read(tmp_path, "frame,x (rod),y (rod)\n0,1.5,25\n1,1.6,24\n")
    assert table.metres is None
    assert table.notes == ("the table's unit “rod” is not known, and does not count",)
    with pytest.raises(InputError, match=r"times in “jiffies”.* rename the column “t .jiffies.”"):
        read(tmp_path, "t (jiffies),x,y\n0,1.5,25\n1,1.6,24\n")


@pytest.mark.parametrize(
    "text",
    [
        'frame,x,y\n0,"0.5","1,375.64"\n1,"1,000","999"\n',
        'frame,x,y\n0,0.5,"1,375"\n1,"1,000",999.5\n',
        "frame;x;y\n0;0,5;1.375,64\n1;1.000;999\n",
        "frame;x;y\n0;0,5;1.375\n1;1.000;999,5\n",
    ],
)
def test_what_parts_thousands_is_no_decimal_point(text: str, tmp_path: Path) -> None:
    table = read(tmp_path, text)
    assert table.places[:, 0].tolist() == [0.5, 1000.0]
    assert table.places.round().tolist()[0][1] in {1375.0, 1376.0}
    assert table.notes == ()


def test_cells_that_hold_no_number_are_said(tmp_path: Path) -> None:
    table = read(tmp_path, "frame,x,y\n0,1,2\n1,far,2\n2,,\n3,1,off\n4,1,2\n")
    assert table.frames.tolist() == [0, 4]
    (said,) = table.notes
    assert said.startswith("2 cells of places that hold no number, the first in line 3: “far”")


@pytest.mark.parametrize("none", ["0,0", "-1,-1"])
def test_a_place_at_0_0_far_from_those_beside_it_is_none(none: str, tmp_path: Path) -> None:
    rows = [f"{k},{100 + k},{200 - k}" if k % 9 else f"{k},{none}" for k in range(40)]
    table = read(tmp_path, "\n".join(["frame,x,y", *rows]))
    assert table.frames.tolist() == [k for k in range(40) if k % 9]
    (said,) = table.notes
    assert said.startswith("5 places at exactly 0, 0 or -1, -1, far from those beside")
    assert "the first in line 2:" in said
    # A ball that goes through the origin of the table's axes does.
    rows = [f"{k},{k - 20},{20 - k}" for k in range(40)]
    assert len(read(tmp_path, "\n".join(["frame,x,y", *rows])).frames) == 40


def test_two_tracks_of_one_table_are_two_things_and_what_is_below_them_is_said(
    tmp_path: Path,
) -> None:
    path = tmp_path / "Results.csv"
    path.write_text(MTRACK)
    table = read_track_table(path)
    assert table.places.tolist() == [[1.5, 25.0], [1.6, 24.0], [9.0, 9.0]]
    assert table.things.tolist() == ["0", "0", "1"]
    assert table.notes == ("2 lines below the places, from line 5 on (“Track”), were not read",)


@given(
    numbers=st.lists(
        # Places at 0, 0 and -1, -1 may be none.
        st.tuples(*[st.floats(-1e6, 1e6).map(lambda value: round(value, 4))] * 2).filter(
            lambda place: place not in {(0.0, 0.0), (-1.0, -1.0)}
        ),
        min_size=1,
    ),
    separator=st.sampled_from(["\t", ";", ","]),
    comma=st.booleans(),
)
def test_any_numbers_are_read_back_with_any_separator(
    numbers: list[tuple[float, float]],
    separator: str,
    comma: bool,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    def cell(value: float) -> str:
        return f"{value:.4f}".replace(".", "," if comma and separator != "," else ".")

    rows = [separator.join(["frame", "x", "y"])]
    rows += [separator.join([str(n), cell(x), cell(y)]) for n, (x, y) in enumerate(numbers)]
    path = tmp_path_factory.mktemp("table") / "table.txt"
    path.write_text("\r\n".join(rows), encoding="utf-8-sig")
    table = read_track_table(path)
    assert table.places.tolist() == np.array(numbers).tolist()
    assert table.frames.tolist() == list(range(len(numbers)))


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"shot,v_n\n1,2\n", "no line that names columns x and y"),
        (b"frame,x,y\n", "no number below its names in line 1"),
        (b"frame,x,y\n1,\0\0", "is no text"),
        (b"frame,left,top\n0,1,2\n", "its columns are “frame”, “left”, “top”: rename those"),
        (b"Bounce,Time (s)\n0,1.5\n1,2.0\n", "stand in one row below Bounce 0"),
        (b"0,1.5,25\n1,1.6,24\n", "its first line holds 3 numbers and no names"),
        (b"", "no line that names columns x and y"),
    ],
)
def test_what_is_no_table_of_places_is_refused_with_what_it_lacks(
    content: bytes, reason: str, tmp_path: Path
) -> None:
    path = tmp_path / "table.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=reason):
        read_track_table(path)
