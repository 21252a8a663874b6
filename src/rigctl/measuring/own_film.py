"""A film of a ball that somebody hands over: looked at, measured, and written as a campaign.

The functions that end in `_job` are called in processes of their own: a file of any kind may be
broken. Each takes one JSON object and a function that says how far it is, and returns one.
"""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.balls.analysis import FilmJob
from analysis.balls.films.film import FilmHead, Picture
from analysis.balls.films.part import Cut
from analysis.balls.films.reading import open_film
from analysis.balls.flight.known import AIR_DENSITY, UNKNOWN_DENSITY, Ball
from analysis.balls.searching import rings
from analysis.balls.tracks.bounce_times import read_bounce_times
from analysis.balls.tracks.table import is_table_of_bounces, read_track_table
from analysis.errors import InputError, ShotRefusedError, counted
from analysis.exchange.description import description
from analysis.exchange.folder import write_ball_poses, write_impacts
from analysis.exchange.impact_table import ImpactRow
from analysis.exchange.pose_table import PoseRow
from analysis.exchange.shot_list import ShotRow
from analysis.quantity import Quantity
from analysis.setup import CameraSetup, Environment, Setup, SlowErrors, SphereSetup
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
from rigctl.measuring.ball_results import ball_result
from rigctl.progress import Progress

SHOWN = 8
SHOWN_WIDTH = 720
QUALITY = 80


def stated_ball(diameter_mm: float, mass_g: float | None, diameter_sigma: float = 0.0) -> Ball:
    """Return a ball as a person states it; without a mass its density is unknown.

    `diameter_sigma` is the diameter's relative standard error.
    """
    diameter = 1e-3 * diameter_mm
    density = None if mass_g is None else 1e-3 * mass_g / (math.pi / 6 * diameter**3)
    return Ball(diameter, diameter_sigma, density=density, air_density=AIR_DENSITY)


def write_ball_campaign(
    folder: Path,
    name: str,
    ball: Ball,
    camera: tuple[float | None, tuple[int, int]],
    shots: Iterable[Json],
) -> None:
    """Write the flights of measured films as an exchange folder, each film a shot.

    Of bounces that were heard there are no flights: each is a shot with its speeds.

    Parameters
    ----------
    camera
        Frames a second, None where nobody states them, and rows and columns of a picture.
    shots
        Documents of films with their numbers as `shot`; one without a bounce is left out.
    """
    measured = list(shots)
    flights = {shot["shot"]: shot["poses"] for shot in measured if "poses" in shot}
    setup = ball_setup(ball, camera, list(flights.values()))
    heard = [
        impact for shot in measured if "poses" not in shot for impact in shot.get("impacts", ())
    ]
    if heard and not flights:
        rows = [ShotRow(number, None, {}, {}) for number in range(1, len(heard) + 1)]
        impacts = [impact_row(number, one) for number, one in enumerate(heard, start=1)]
        write_impacts(folder, description(name, setup), rows, impacts)
        return
    write_ball_poses(folder, name, setup, {n: pose_rows(one) for n, one in flights.items()})


def ball_setup(
    ball: Ball, camera: tuple[float | None, tuple[int, int]], told: Sequence[Json]
) -> Setup:
    """Return the set-up in which the poses of measured films stand.

    Parameters
    ----------
    camera
        As `write_ball_campaign` has it.
    told
        `poses` of the films' documents.
    """
    rate_hz, size = camera
    density = UNKNOWN_DENSITY if ball.density is None else ball.density
    return Setup(
        camera=CameraSetup(
            rate_hz or 1.0,
            *size,
            scale_px_per_m=float(np.median([one["scale_px_per_m"] for one in told]))
            if told
            else None,
        ),
        spheres=(
            SphereSetup("a", ball.diameter_m, density),
            SphereSetup("b", plate=True, normal=_mean_normal(told)),
        ),
        environment=Environment(
            ball.gravity,
            ball.air_density,
            ball.drag_coefficient,
            ball.drag_coefficient * ball.drag_per_m()[1],
        ),
        measurement=SlowErrors(
            position_m=max((one["slow_m"] for one in told), default=0.0),
            scale=max((one["scale_sigma"] for one in told), default=0.0),
            one_body_frame=False,
        ),
    )


def _mean_normal(flights: Sequence[Json]) -> tuple[float, float, float] | None:
    """Return the plate's normal as the films have it; None: there is none."""
    if not flights:
        return None
    x, y, z = np.mean([one["normal"] for one in flights], axis=0)
    return float(x), float(y), float(z)


def impact_row(shot: int, impact: Json) -> ImpactRow:
    """Return the row of impacts.csv of a bounce whose v_s was not seen."""
    before, after = (Quantity.from_json(impact[key]) for key in ("v_n", "v_n_after"))
    return ImpactRow(
        shot,
        (before.value, math.nan, after.value, math.nan),
        (before.sigma, None, after.sigma, None),
    )


def pose_rows(poses: Json) -> list[PoseRow]:
    """Return the rows of poses.csv; orientations and the third coordinate were not seen."""
    columns = (poses[key] for key in ("frame", "t_s", "x_m", "y_m", "sigma_x_m", "sigma_y_m"))
    return [
        PoseRow(frame, t, (x, y, math.nan), (sigma_x, sigma_y, math.inf), None, math.inf)
        for frame, t, x, y, sigma_x, sigma_y in zip(*columns, strict=True)
    ]


def _shown(path: Path) -> tuple[FilmHead, dict[int, Picture]]:
    """Return what a film says of itself, and the pictures of it that are shown, by frame."""
    try:
        film = open_film(path)
        last = film.head.frames - 1
        return film.head, film.chosen(sorted({round(k * last / (SHOWN - 1)) for k in range(SHOWN)}))
    except InputError as error:
        raise AnalysisInputError(error.reason, part=Path(error.path).name) from error


def rings_job(asked: Json, progress: Progress) -> Json:
    """Say where the ball is in the pictures that are shown, each ring as column, row and radius.

    They are pixels from the corner of the picture; `path` is the film.
    """
    progress("what is round and moves", None)
    _, pictures = _shown(Path(asked["path"]))
    found = rings(pictures)
    return {
        "rings": [
            {"frame": k, "ring": [one.column + 0.5, one.row + 0.5, one.radius]}
            for k, one in sorted(found.items())
        ]
    }


def look_job(asked: Json, progress: Progress) -> Json:
    """Say what a film is, and show pictures of it as JPEG; `path` is the film."""
    progress("opening the film", None)
    head, found = _shown(Path(asked["path"]))
    return {
        "frames": head.frames,
        "rows": head.height,
        "columns": head.width,
        "rate_hz": head.rate_hz,
        "notes": list(head.notes),
        "pictures": [{"frame": k, "jpeg": _jpeg(found[k])} for k in sorted(found)],
    }


def table_job(asked: Json, progress: Progress) -> Json:
    """Say in words what a table holds, whether it states times, and whether bounces were heard.

    `path` is the table.
    """
    progress("reading the table", None)
    path = Path(asked["path"])
    try:
        if is_table_of_bounces(path):
            heard = int(np.isfinite(read_bounce_times(path).times_s).sum())
            said = f"times of {counted(heard, 'bounce')} that were heard"
            return {"said": said, "timed": True, "heard": True}
        table = read_track_table(path)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=path.name) from error
    things = len(np.unique(table.things))
    said = f"{counted(len(table.places), 'place')} of {counted(things, 'thing')}, " + (
        "with times" if table.states_times else "without times"
    )
    return {"said": said, "timed": table.states_times, "heard": False}


def measure_job(asked: Json, progress: Progress) -> Json:
    """Measure one film, or table, of some; write figure and result, and the campaign of all so far.

    `path` is the film or table and `shot` its number, `diameter_mm` the ball's and `diameter_sigma`
    its relative standard error; `mass_g`, `rate_hz` and `window` (column, row, width, height) are
    None where nothing is stated; `figure`, `result` and `campaign` are where to write, `name` is
    what to call it and `title` the campaign, `earlier` are results of other films.
    """
    window = asked["window"]
    ball = stated_ball(asked["diameter_mm"], asked["mass_g"], asked["diameter_sigma"])
    job = FilmJob(
        shot=asked["shot"],
        path=Path(asked["path"]),
        ball=ball,
        rate_hz=asked["rate_hz"],
        cut=None if window is None else Cut(0, None, tuple(window)),
    )
    progress("finding the ball and following it", 0.1)
    try:
        result = ball_result(job)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=Path(error.path).name) from error
    except ShotRefusedError as refusal:
        raise AnalysisInputError(refusal.reason, part=f"the {refusal.step}") from refusal
    document = result.document
    progress("drawing", 0.8)
    if result.draw is not None:
        result.draw(Path(asked["figure"]), asked["name"])
    Path(asked["result"]).write_text(json.dumps(document, allow_nan=False), encoding="utf-8")
    earlier = [json.loads(Path(path).read_text("utf-8")) for path in asked["earlier"]]
    shots = sorted([*earlier, document], key=lambda one: int(one["shot"]))
    write_ball_campaign(
        Path(asked["campaign"]), asked["title"], ball, (asked["rate_hz"], result.size), shots
    )
    return document


def _jpeg(picture: Picture) -> str:
    """Return a picture as JPEG in base64, in 8 bits and no wider than a page shows it."""
    grey: NDArray[Any] = picture.squeeze()
    if grey.dtype != np.uint8:
        grey = (grey.astype(np.float64) * (255.0 / max(float(grey.max()), 1.0))).astype(np.uint8)
    share = SHOWN_WIDTH / grey.shape[1]
    if share < 1:
        grey = cv2.resize(grey, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return base64.b64encode(data.tobytes()).decode("ascii")
