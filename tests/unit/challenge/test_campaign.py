from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from simulators.challenge.camera import OPTICS
from simulators.challenge.campaign import Campaign, Noise, run_campaign
from simulators.challenge.effects import HIDDEN, switched
from simulators.challenge.nature import Nature

Floats = NDArray[np.float64]

EXACT = Noise(centre_px=1e-9, rotation_rad=1e-12)


def turned(first: Floats, second: Floats) -> Floats:
    """Return the rotation vectors (N, 3) from orientations (..., 4) to others."""
    before = Rotation.from_quat(first.reshape(-1, 4), scalar_first=True)
    after = Rotation.from_quat(second.reshape(-1, 4), scalar_first=True)
    return np.asarray((after * before.inv()).as_rotvec())


def gaps(campaign: Campaign) -> Floats:
    """Return the gap between the surfaces (S, F), m."""
    apart = campaign.centres[:, :, 1] - campaign.centres[:, :, 0]
    return np.asarray(np.linalg.norm(apart, axis=-1) - 0.0254)


def test_noise_has_the_stated_size() -> None:
    noisy, exact = run_campaign(Nature(), 3), run_campaign(Nature(), 3, noise=EXACT)
    off = noisy.centres - exact.centres
    assert noisy.centre_sigma_m == pytest.approx(0.03 / 1574.8)
    assert off.std() == pytest.approx(0.03 / 1574.8, rel=0.02)
    assert abs(off.mean()) < 4 * 0.03 / 1574.8 / np.sqrt(off.size)
    wrong = turned(exact.orientations, noisy.orientations)
    np.testing.assert_allclose(wrong.std(axis=0), np.radians(0.46), rtol=0.04)
    assert noisy.rotation_sigma_rad == pytest.approx(np.radians(0.46))


def test_a_seed_gives_the_same_campaign_and_another_seed_another() -> None:
    first, again, other = (run_campaign(Nature(), seed, shots=4) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.centres, again.centres)
    np.testing.assert_array_equal(first.orientations, again.orientations)
    assert (first.centres != other.centres).all()


def test_two_natures_share_launch_and_noise_of_one_seed() -> None:
    plain = run_campaign(Nature(), 5, shots=20)
    changed = run_campaign(Nature(restitution_drift=0.1), 5, shots=20)
    np.testing.assert_array_equal(plain.centres[:, :12], changed.centres[:, :12])
    assert (plain.centres[:, 12:] != changed.centres[:, 12:]).any(axis=(1, 2, 3)).all()


def test_spheres_touch_between_the_two_middle_frames_and_never_overlap() -> None:
    for nature in (Nature(), Nature(softness=1.0, compliance=1.0)):
        gap = gaps(run_campaign(nature, 2, noise=EXACT))
        assert gap[:, [11, 12]].max() < 0.012
        assert (np.diff(gap[:, :12], axis=1) < 0.0).all()
        assert (np.diff(gap[:, 13:], axis=1) > 0.0).all()
        assert gap.min() > -4e-4


def test_a_frame_inside_a_soft_contact_shows_the_compressed_spheres() -> None:
    gap = gaps(run_campaign(Nature(softness=1.0), 2, noise=EXACT))
    inside = gap[:, 12] < -2e-5
    assert 0.05 < inside.mean() < 0.3
    assert (gaps(run_campaign(Nature(), 2, noise=EXACT)) > -1e-9).all()


def test_spins_are_constant_on_either_side_of_the_contact() -> None:
    campaign = run_campaign(Nature(), 4, shots=10, noise=EXACT)
    q = campaign.orientations
    for frames in (slice(0, 12), slice(12, 24)):
        steps = turned(q[:, frames][:, :-1], q[:, frames][:, 1:]).reshape(10, 11, 2, 3)
        np.testing.assert_allclose(steps, steps[:, :1].repeat(11, axis=1), atol=1e-9)


def test_settings_are_spread_and_not_in_order() -> None:
    settings = run_campaign(Nature(), 1).settings
    for values, low, high in ((settings.pressure_kpa, 12, 95), (settings.offset_mm, 0, 22)):
        counts, _ = np.histogram(values, bins=6, range=(low, high))
        assert counts.tolist() == [20] * 6
        assert abs(np.corrcoef(values, settings.order)[0, 1]) < 0.3
    assert abs(np.corrcoef(settings.pressure_kpa, settings.offset_mm)[0, 1]) < 0.3


def test_every_centre_lies_in_both_views() -> None:
    campaign = run_campaign(Nature(), 6)
    x, y, z = np.moveaxis(campaign.centres, -1, 0)
    row, column = OPTICS.front_origin_px[0] + 1574.8 * x, OPTICS.front_origin_px[1] + 1574.8 * y
    mirrored = OPTICS.top_origin_px[0] - 1574.8 * z
    assert OPTICS.front_rows[0] < row.min()
    assert row.max() < OPTICS.front_rows[1]
    assert OPTICS.top_rows[0] < mirrored.min()
    assert mirrored.max() < OPTICS.top_rows[1]
    assert column.min() > 0
    assert column.max() < OPTICS.columns


@pytest.mark.parametrize("name", sorted(HIDDEN))
def test_every_hidden_effect_can_be_seen_above_the_noise(name: str) -> None:
    plain = run_campaign(Nature(), 8, noise=EXACT)
    changed = run_campaign(switched({name: HIDDEN[name].amplitude}), 8, noise=EXACT)
    moved = (changed.centres - plain.centres) / (0.03 / 1574.8)
    spun = turned(plain.orientations, changed.orientations) / np.radians(0.46)
    assert (moved**2).sum() + (spun**2).sum() > 25.0


def test_a_wrong_frame_rate_lengthens_the_way_between_frames() -> None:
    plain = run_campaign(Nature(), 8, noise=EXACT).centres[:, :12]
    slow = run_campaign(Nature(frame_rate=0.01), 8, noise=EXACT).centres[:, :12]
    way, longer = (np.diff(centres[..., 1], axis=1) for centres in (plain, slow))
    np.testing.assert_allclose(longer, 1.01 * way, rtol=1e-9)
