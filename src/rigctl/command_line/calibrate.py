"""`rigctl calibrate`: the camera as the shots of a campaign show it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rigctl.command_line.options import Json

calibration = typer.Typer()


@calibration.command("calibrate")
def calibrate(
    campaign: Annotated[Path, typer.Argument(help="Campaign folder with frames.")],
    *,
    json: Json = False,
) -> None:
    """Estimate scale, aspect, mirror, roll, distortion and perspective from the shots."""
    from rigctl.commands.analysis.calibrate import calibrate as estimate

    estimate(campaign, as_json=json)
