from __future__ import annotations

import json
import math

from hypothesis import given
from hypothesis import strategies as st

from analysis.exchange.pose_table import PoseRow
from rigctl.measuring.stored_poses import poses_document, poses_of

length = st.floats(-1.0, 1.0)
sigma = st.floats(1e-9, 1e-2)


@st.composite
def rows(draw: st.DrawFn) -> PoseRow:
    measured = [draw(st.booleans()) for _ in range(3)]
    turned = draw(st.booleans())
    angle = draw(st.floats(-3.0, 3.0))
    x, y, z = (draw(length) if there else math.nan for there in measured)
    u, v, w = (draw(sigma) if there else math.inf for there in measured)
    return PoseRow(
        frame=draw(st.integers(0, 6000)),
        t_s=draw(st.floats(0.0, 30.0)),
        position=(x, y, z),
        position_sigma=(u, v, w),
        quaternion=(math.cos(angle), 0.0, math.sin(angle), 0.0) if turned else None,
        rotation_sigma=draw(sigma) if turned else math.inf,
        turn_covariance=(1e-6, 2e-6, 3e-5, 0.0, 1e-7, draw(sigma)) if turned else None,
    )


@given(st.lists(rows(), max_size=5), st.lists(rows(), max_size=5))
def test_poses_come_back_from_json_as_they_went_in(a: list[PoseRow], b: list[PoseRow]) -> None:
    text = json.dumps(poses_document({"a": a, "b": b}), allow_nan=False)
    # NaN is no value equal to itself, so that what was not measured is compared as text.
    assert repr(poses_of(json.loads(text))) == repr({"a": a, "b": b})


def test_what_was_not_measured_is_null() -> None:
    row = PoseRow(3, 0.003, (0.1, math.nan, 0.3), (1e-5, math.inf, 2e-5), None, math.inf)
    assert poses_document({"a": [row], "b": []}) == [
        {
            "sphere": "a",
            "frame": 3,
            "t_s": 0.003,
            "position_m": [0.1, None, 0.3],
            "sigma_m": [1e-5, None, 2e-5],
            "quaternion": None,
            "sigma_rot_rad": None,
            "cov_rot_rad2": None,
        }
    ]
