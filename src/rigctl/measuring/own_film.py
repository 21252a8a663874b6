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

from analysis.balls.analysis import FilmJob, analyse_film
from analysis.balls.document import ball_document
from analysis.balls.films.film import FilmHead, Picture
from analysis.balls.films.part import Cut
from analysis.balls.films.reading import open_film
from analysis.balls.flight.known import AIR_DENSITY, UNKNOWN_DENSITY, Ball
from analysis.balls.searching import rings
from analysis.errors import InputError, ShotRefusedError
from analysis.exchange.folder import write_ball_poses
from analysis.exchange.pose_table import PoseRow
from analysis.figures.ball_film import draw_ball_film
from analysis.setup import CameraSetup, Environment, Setup, SlowErrors, SphereSetup
from rigctl.documents import Json
from rigctl.errors import AnalysisInputError
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

    Parameters
    ----------
    camera
        Frames a second, None where nobody states them, and rows and columns of a picture.
    shots
        Documents of films with their numbers as `shot`; one without a bounce is left out.
    """
    flights = {shot["shot"]: shot["poses"] for shot in shots if "poses" in shot}
    setup = ball_setup(ball, camera, list(flights.values()))
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


def measure_job(asked: Json, progress: Progress) -> Json:
    """Measure one of some films, write figure and result, and the campaign of all measured so far.

    `path` is the film and `shot` its number, `diameter_mm` the ball's and `diameter_sigma` its
    relative standard error; `mass_g`, `rate_hz` and
    `window` (column, row, width, height) are None where nothing is stated; `figure`, `result` and
    `campaign` are where to write, `name` is what to call it and `title` the campaign, `earlier` are
    results of other films.
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
        film = analyse_film(job)
    except InputError as error:
        raise AnalysisInputError(error.reason, part=Path(error.path).name) from error
    except ShotRefusedError as refusal:
        raise AnalysisInputError(refusal.reason, part=f"the {refusal.step}") from refusal
    document = {"shot": asked["shot"], **ball_document(film.measured, film.notes)}
    progress("drawing", 0.8)
    draw_ball_film(Path(asked["figure"]), asked["name"], film)
    Path(asked["result"]).write_text(json.dumps(document, allow_nan=False), encoding="utf-8")
    size = film.film.head.height, film.film.head.width
    earlier = [json.loads(Path(path).read_text("utf-8")) for path in asked["earlier"]]
    shots = sorted([*earlier, document], key=lambda one: int(one["shot"]))
    write_ball_campaign(
        Path(asked["campaign"]), asked["title"], ball, (asked["rate_hz"], size), shots
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
