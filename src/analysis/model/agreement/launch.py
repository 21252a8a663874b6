"""The launch as a stage of the table: how well settings foretell the spheres at their muzzles."""

from __future__ import annotations

import numpy as np

from analysis.launch.agreement import launch_agreement
from analysis.model.agreement.table import Row, Stage
from analysis.model.data.stream import CampaignData, whole
from analysis.model.fitting.fit import Fit


def launch_stage(data: CampaignData, fit: Fit) -> Stage:
    """Return the stage of the launch; its noise is the scatter of the launches themselves.

    That scatter is estimated from the same shots, so that chi-squared is its degrees of freedom
    and there is nothing to test: every p-value is 1.

    Raises
    ------
    LaunchRefusedError
        The settings do not let launches be fitted.
    """
    rows = []
    for found in launch_agreement(whole(data), fit):
        scatter = max(found.scatter, np.finfo(float).tiny)
        rows.append(
            Row(
                quantity=found.quantity,
                unit=found.unit,
                count=found.count,
                chi2=found.chi2_with_scatter,
                freedom=found.freedom,
                p_value=1.0,
                error=found.prediction_rms / scatter,
                sampling=float(np.sqrt(0.5 / found.count)),
                size=found.prediction_rms,
                floor=found.scatter,
            )
        )
    return Stage("launch", tuple(rows))
