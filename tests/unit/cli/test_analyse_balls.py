"""`rigctl analyse` of films of one ball, held against the law that they were drawn with."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from analysis.balls import settling
from analysis.balls.flight.fit import fit_flights
from analysis.balls.flight.flights import Flights, Observed, Start
from analysis.balls.flight.known import Known
from analysis.exchange.impact_table import read_impacts
from analysis.exchange.pose_table import read_poses
from analysis.model.data.gather import gather
from analysis.model.data.poses import PoseData
from analysis.model.data.tables import ContactTable
from benchmarks.balls.missing import films, of_folder, told
from rigctl import cli
from tests.unit.cli.falling_ball import (
    DIAMETER_MM,
    FALL,
    RADIUS,
    RATE,
    SIZE,
    answer,
    bouncing,
    picture,
    write,
)

DROPS = Path(__file__).parents[4] / "shared" / "data" / "drops"


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("drawn") / "film", bouncing())


def test_a_film_without_any_folder_gives_e_of_every_bounce(
    film: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    size = ["--ball-diameter-mm", f"{DIAMETER_MM:.3f}", "--fps", "200"]
    shot = answer(capsys, str(film), *size, "--exposure-us", "0")
    assert shot["status"] == "measured"
    assert len(shot["impacts"]) >= 1
    times = [impact["contact_time_s"] for impact in shot["impacts"]]
    assert times == sorted(times)
    for impact in shot["impacts"]:
        e = impact["e"]
        # Drawn in a vacuum: the drag of an unknown ball is what its error holds.
        assert e["value"] == pytest.approx(0.8, abs=max(4 * e["sigma"], 0.005))
        assert e["sigma"] < 0.02
        assert impact["v_n"]["value"] < 0 < impact["v_n_after"]["value"]
        assert impact["v_s"]["value"] is None
        assert impact["v_s"]["low"] <= impact["v_s"]["high"]
    assert shot["ball"]["diameter_px"]["value"] == pytest.approx(2 * RADIUS, rel=0.02)
    assert not [note for note in shot["notes"] if "missing" in note]


@pytest.mark.parametrize("share", [0.5, pytest.param(1.15, marks=pytest.mark.long), 2.0])
def test_a_diameter_that_is_wrong_is_contradicted_by_the_fall(
    share: float, film: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    size = ["--ball-diameter-mm", f"{share * DIAMETER_MM:.3f}", "--fps", "200"]
    shot = answer(capsys, str(film), *size, "--exposure-us", "0")
    assert not shot["scale_px_per_m"]["agree"]
    (note,) = [note for note in shot["notes"] if "contradicts gravity" in note]
    assert float(note.split("the ball is ")[1].split()[0]) == pytest.approx(1 / share, rel=0.03)
    assert shot["impacts"][0]["e"]["value"] == pytest.approx(0.8, abs=0.01)


@pytest.mark.parametrize(
    ("rows", "columns", "words"),
    [
        ([100.0] * 40, [20.0 + 2 * k for k in range(40)], "rolls"),
        ([60 + 30 * np.sin(k / 6) for k in range(60)], None, "held"),
    ],
)
def test_a_ball_that_does_not_fly_is_refused_with_frames_and_place(
    rows: list[float],
    columns: list[float] | None,
    words: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    folder = write(tmp_path / "film", rows, columns)
    shot = answer(capsys, str(folder), "--ball-diameter-mm", "20", "--fps", "1000")
    assert shot["status"] == "refused"
    assert words in shot["reason"]
    assert "px" in shot["reason"]
    # Its places stand all the same.
    places = shot["positions"]
    drawn = [(rows[k], 60.0 if columns is None else columns[k]) for k in places["frame"]]
    found = np.stack([places["row_px"], places["column_px"]], axis=1)
    assert len(drawn) > 0.7 * len(rows)
    assert np.median(np.hypot(*(found - np.array(drawn)).T)) < 0.3


def test_a_film_without_a_ball_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write(tmp_path / "film", [-100.0] * 12)
    shot = answer(capsys, str(folder), "--ball-diameter-mm", "20", "--fps", "200")
    assert (shot["status"], shot["step"]) == ("refused", "ball")


def test_a_ball_that_rests_in_all_frames_is_refused_with_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write(tmp_path / "film", [120.25] * 12)
    shot = answer(capsys, str(folder), "--ball-diameter-mm", "20", "--fps", "200")
    assert (shot["status"], shot["step"]) == ("refused", "ball")
    assert "rests or turns on its place: at (120." in shot["reason"]


def test_a_film_that_ends_in_the_middle_of_a_bounce_gives_the_flights_before_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = bouncing(180)
    lowest = [k for k in range(1, 179) if rows[k - 1] < rows[k] > rows[k + 1]]
    film = write(tmp_path / "film", rows[: lowest[1] + 2])
    size = ["--ball-diameter-mm", f"{DIAMETER_MM:.3f}", "--fps", "200", "--exposure-us", "0"]
    shot = answer(capsys, str(film), *size)
    assert shot["status"] == "measured"
    assert len(shot["impacts"]) == 1
    assert shot["impacts"][0]["e"]["value"] == pytest.approx(0.8, abs=0.02)
    # A person sees the second bounce: why it is not used is said, with its frame.
    (said,) = [note for note in shot["notes"] if note.startswith("bounce 2, ")]
    frame = float(said.split("about frame ")[1].split()[0])
    assert frame == pytest.approx(lowest[1], abs=1.0)
    assert f"the film ends 1 frame after it, at frame {lowest[1] + 1}; 4 are needed" in said
    assert not any("leaves the picture" in note for note in shot["notes"])


def test_a_film_that_stands_upside_down_is_said_and_measured(
    film: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "turned").mkdir()
    for path in film.iterdir():
        upright = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        assert upright is not None
        cv2.imwrite(str(tmp_path / "turned" / path.name), upright[::-1, ::-1])
    size = ["--ball-diameter-mm", f"{DIAMETER_MM:.3f}", "--fps", "200", "--exposure-us", "0"]
    shot = answer(capsys, str(tmp_path / "turned"), *size)
    assert "upside down" in shot["notes"][0]
    assert shot["impacts"][0]["e"]["value"] == pytest.approx(0.8, abs=0.02)


def test_a_second_ball_is_named_with_its_frames(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "two"
    folder.mkdir()
    for k, row in enumerate(bouncing()):
        both = np.hstack([picture(row), picture(40 + 0.5 * FALL * ((70 - k) / RATE) ** 2)])
        cv2.imwrite(str(folder / f"{k:04d}.png"), both)
    size = ["--ball-diameter-mm", f"{DIAMETER_MM:.3f}", "--fps", "200", "--exposure-us", "0"]
    shot = answer(capsys, str(folder), *size)
    assert any("another ball" in note for note in shot["notes"])
    assert shot["impacts"][0]["e"]["value"] == pytest.approx(0.8, abs=0.02)


def test_a_film_without_a_rate_asks_for_it(film: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shot = answer(capsys, str(film), "--ball-diameter-mm", "100")
    assert shot["status"] == "refused"
    assert "--fps" in shot["reason"]


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--frames", "x", "--frames"),
        ("--roi", "1,2", "--roi"),
        ("--frames", "90:400", "100 frames"),
        ("--figure", "bounce.xyz", ".png, "),
        ("--out", __file__, "is a file"),
    ],
)
def test_an_option_that_cannot_be_is_bad_input(
    option: str, value: str, words: str, film: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["analyse", str(film), "--ball-diameter-mm", "100", "--fps", "200"]
    assert cli.run([*arguments, option, value]) == cli.BAD_INPUT
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["jpeg", "TIF", "eps", "png"])
def test_a_picture_may_be_of_any_kind_that_can_be_drawn(
    kind: str, film: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["analyse", str(film), "--ball-diameter-mm", "100", "--figure", f"bounce.{kind}"]
    assert cli.run([*arguments, "--roi", "1,2"]) == cli.BAD_INPUT
    # The picture's name is looked at first: nothing is wrong with it.
    assert "--roi" in capsys.readouterr().err


def test_options_of_a_ball_without_a_ball_are_refused(
    film: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["analyse", str(film), "--roi", "0,0,50,50"]) == cli.BAD_INPUT
    assert "--ball-diameter-mm" in capsys.readouterr().err


def test_only_the_frames_that_are_asked_for_count(
    film: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    size = ["--ball-diameter-mm", f"{DIAMETER_MM:.3f}", "--fps", "200", "--exposure-us", "0"]
    shot = answer(capsys, str(film), *size, "--frames", "20:100", "--roi", "10,0,100,240")
    assert "frames 20 to 99 of 100" in shot["notes"][0]
    assert "count from frame 20" in shot["notes"][0]
    assert "columns 10 to 109 and rows 0 to 239" in shot["notes"][0]
    assert shot["impacts"][0]["e"]["value"] == pytest.approx(0.8, abs=0.02)


def track(path: Path) -> Path:
    """Write the places of the drawn ball as a tracker does: frames, and pixels downwards."""
    places = bouncing(200)
    rows = [f"{frame},{row:.3f},60.0" for frame, row in enumerate(places)]
    path.write_text("\n".join(["frame,y,x", *rows]))
    return path


def test_a_tracker_s_table_gives_e_of_every_bounce_and_poses_that_the_model_reads(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = track(tmp_path / "table.csv")
    out = tmp_path / "out"
    shot = answer(capsys, str(table), *SIZE, "--fps", "200", "--out", str(out))
    assert [impact["e"]["value"] for impact in shot["impacts"]] == pytest.approx(
        [0.8, 0.8], abs=1e-3
    )
    _, data = gather(out)
    assert isinstance(data, PoseData)
    # The k-th bounce of shot 1 is impact 100 + k.
    assert data.shots.tolist() == [101, 102]
    figure = tmp_path / "figures" / "bounces.png"
    answer(capsys, str(table), *SIZE, "--fps", "200", "--figure", str(figure))
    assert cv2.imread(str(figure)).std() > 10


def test_bounces_that_were_heard_become_impacts_that_the_model_reads(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # Each flight lasts 0.9 of the one before: in a vacuum that is e.
    times = 0.5 + 0.8 * np.cumsum(0.9 ** np.arange(8))
    names = ",".join(f"Bounce {k} (s)" for k in range(len(times)))
    table, out = tmp_path / "heard.csv", tmp_path / "out"
    table.write_text(f"{names}\n{','.join(f'{t:.5f}' for t in times)}\n")
    shot = answer(capsys, str(table), *SIZE, "--ball-mass-g", "500", "--out", str(out))
    _, data = gather(out)
    assert isinstance(data, ContactTable)
    assert len(data.shots) == len(shot["impacts"]) == 6
    came = [impact.speeds[0] for impact in read_impacts(out / "impacts.csv")]
    assert came == [each["v_n"]["value"] for each in shot["impacts"]]
    figure = ["--figure", str(tmp_path / "a.png")]
    assert cli.run(["analyse", str(table), *SIZE, *figure]) == cli.BAD_INPUT
    assert "bounces that were heard have none" in capsys.readouterr().err


def test_what_asks_for_pictures_of_a_table_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = str(track(tmp_path / "table.csv"))
    shot = answer(capsys, table, *SIZE, "--fps", "200", "--roi", "0,0,9,9")
    assert "a table has no pictures" in shot["reason"]


def test_flights_become_poses_that_the_model_reads(film: Path, tmp_path: Path) -> None:
    size = ["--ball-diameter-mm", f"{DIAMETER_MM:.3f}", "--fps", "200", "--exposure-us", "0"]
    out = tmp_path / "bounces"
    out.mkdir()
    (out / "impacts.csv").write_text("shot,v_n\n1,-1.0\n", encoding="utf-8")
    assert cli.run(["analyse", str(film), *size, "--out", str(out)]) == 0
    _, data = gather(out)
    assert isinstance(data, PoseData)
    assert data.on_plate
    assert len(data.shots) >= 1
    # Drawn places, m down from the lowest: the film's scale and light leave a share of them.
    drawn = (np.array(bouncing()) - max(bouncing())) * 9.80665 / FALL
    rows = next(iter(read_poses(out / "poses.csv").values()))["a"]
    off = np.array([row.position[0] - drawn[row.frame] for row in rows])
    assert np.ptp(off) < 0.01 * np.ptp(drawn)
    assert cli.run(["analyse", str(film), *size, "--out", str(film)]) == cli.BAD_INPUT


@pytest.mark.shared_data
@pytest.mark.skipif(not DROPS.exists(), reason="films lie beside a development checkout")
@pytest.mark.parametrize(
    ("name", "bounces", "within"),
    [
        pytest.param("bench1000", 1, 0.002, marks=pytest.mark.long),
        pytest.param("high240", 2, 0.005, marks=pytest.mark.long),
        pytest.param("phone60", 5, 0.02, marks=pytest.mark.long),
    ],
)
def test_e_of_drawn_films_is_that_of_their_law(
    name: str, bounces: int, within: float, capsys: pytest.CaptureFixture[str]
) -> None:
    shot = answer(capsys, str(DROPS / name))
    truth = json.loads((DROPS / name / "truth.json").read_text())["bounces"]
    assert len(shot["impacts"]) == bounces
    for impact, drawn in zip(shot["impacts"], truth, strict=False):
        e = impact["e"]
        assert e["value"] == pytest.approx(drawn["e"], abs=within)
        assert abs(e["value"] - drawn["e"]) < 4 * e["sigma"]
        assert impact["v_n"]["value"] == pytest.approx(drawn["v_n"], rel=0.02)
    assert not [note for note in shot["notes"] if "missing" in note]
    if bounces == 1:
        assert shot["e"] == shot["impacts"][0]["e"]


@pytest.mark.shared_data
@pytest.mark.long
@pytest.mark.skipif(not DROPS.exists(), reason="films lie beside a development checkout")
@pytest.mark.parametrize(("first", "count"), [(33, 2), (49, 1), (104, 1)])
def test_frames_that_a_drawn_film_lacks_are_put_into_its_times(
    first: int, count: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In flights of 240 frames/s, and beside its bounces at frames 50.8 and 126.1."""
    pictures = sorted((DROPS / "high240" / "frames" / "0001").glob("*.png"))
    for k, path in enumerate(pictures[:first] + pictures[first + count :]):
        (tmp_path / f"{k:04d}.png").symlink_to(path)
    size = ["--ball-diameter-mm", "40", "--ball-mass-g", "30", "--fps", "240"]
    shot = answer(capsys, str(tmp_path), *size)
    words = f"{count} frames seem" if count > 1 else "1 frame seems"
    assert len([note for note in shot["notes"] if note.startswith(words)]) == 1
    truth = json.loads((DROPS / "high240" / "truth.json").read_text())["bounces"]
    assert len(shot["impacts"]) == len(truth)
    for impact, drawn in zip(shot["impacts"], truth, strict=True):
        e = impact["e"]
        assert abs(e["value"] - drawn["e"]) < 4 * e["sigma"] < 0.004


@pytest.mark.shared_data
@pytest.mark.long
@pytest.mark.skipif(not DROPS.exists(), reason="films lie beside a development checkout")
@pytest.mark.parametrize(("first", "count"), [(26, 1), (109, 2), (113, 1)])
def test_no_e_of_a_telephone_film_that_lacks_frames_at_a_bounce_is_wrong_in_silence(
    first: int, count: int
) -> None:
    """At its first bounce, at its last, and between those of a low flight."""
    found = told(of_folder(DROPS / "phone60"), first, count)
    assert found.outcome in ("mended", "said", "harmless", "fewer bounces")
    assert found.pull < 3.0
    assert found.bounces >= 4


@pytest.mark.long
def test_low_bounces_of_a_telephone_film_are_not_cut_out_of_its_flights(tmp_path: Path) -> None:
    """Of a fall of twice the stated one, the same sightings make a bounce every six frames."""
    found = told(next(films(["telephone"], range(3, 4), tmp_path)))
    assert found.outcome == "harmless"
    assert found.bounces == 3


def test_a_fit_that_goes_astray_late_takes_no_bounces_away(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Places are fitted again as the ball's light is learned; a later fit may hold few of them."""
    calls = []

    def astray(
        observed: Observed, start: Start, known: Known, before: Flights | None
    ) -> Flights | None:
        calls.append(len(observed.frames))
        if len(calls) > 2:
            observed = observed.of(observed.times_s > start.times_s[-2])
            start = start.of(slice(-1, None))
        return fit_flights(observed, start, known, before)

    monkeypatch.setattr(settling, "fit_flights", astray)
    shot = answer(capsys, str(write(tmp_path / "film", bouncing(190))), *SIZE, "--fps", "200")
    assert len(calls) == 3
    assert len(shot["impacts"]) == 2
    assert all(abs(each["e"]["value"] - 0.8) < 0.01 for each in shot["impacts"])


def test_places_further_off_their_flights_than_the_ball_reaches_have_no_e(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Times that no flight fits leave a fit that goes nowhere near the ball."""

    def far_off(observed: Observed, *asked: Any) -> Flights | None:
        found = fit_flights(observed, *asked)
        assert found is not None
        apart = 30.0 * (-1.0) ** np.arange(len(found.residuals))
        return replace(found, residuals=found.residuals + apart[:, None])

    monkeypatch.setattr(settling, "fit_flights", far_off)
    shot = answer(capsys, str(write(tmp_path / "film", bouncing(190))), *SIZE, "--fps", "200")
    assert shot["impacts"] == []
    assert any("no bounce" in note for note in shot["notes"])
