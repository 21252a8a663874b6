"""Tabulated contacts give back the law that made them, through the same fit as poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from analysis.errors import InputError
from analysis.model.data.gather import gather, gather_poses
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.tables import ContactTable
from analysis.model.fitting.fit import Fit, fit_campaign
from analysis.model.fitting.noise import noise_scales
from analysis.model.fitting.outliers import clean
from analysis.model.structure.lackoffit import lack_of_fit
from analysis.model.verdict.crossvalidation import prediction_error
from tests.unit.analysis.model.exchange_folder import DESCRIPTION, write_campaign
from tests.unit.analysis.model.hard_spheres import campaign, draw
from tests.unit.analysis.model.tabulated import (
    PLATE,
    contacts,
    folder_with,
    impacts,
    write_contacts,
)

LAW = (0.74, 0.08, 0.5)


def table(folder: Path) -> ContactTable:
    data = gather(folder)[1]
    assert isinstance(data, ContactTable)
    return data


def assert_law(fit: Fit, law: tuple[float, float, float] = LAW) -> None:
    assert fit.converged
    sigma = np.sqrt(np.diag(fit.covariance))
    assert (np.abs(fit.theory.vector[:3] - law) < 4 * sigma[:3]).all()


def test_states_before_and_after_give_back_the_law_and_their_noise(tmp_path: Path) -> None:
    fit = fit_campaign(table(contacts(tmp_path, 60, 1)))
    assert_law(fit)
    assert fit.freedom == 60 * (24 - 12) - 3
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit.freedom))
    assert np.sqrt(np.diag(fit.covariance))[:2] == pytest.approx([0, 0], abs=2e-3)


def test_scalars_give_back_the_law_and_their_noise(tmp_path: Path) -> None:
    fit = fit_campaign(table(impacts(tmp_path, 60, 2)))
    assert_law(fit)
    assert fit.freedom == 60 * (4 - 2) - 3
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit.freedom))


@pytest.mark.long
def test_stated_errors_cover_the_truth_as_often_as_they_should(tmp_path: Path) -> None:
    pulls = []
    for seed in range(40):
        fit = fit_campaign(table(impacts(tmp_path / str(seed), 20, 100 + seed)))
        pulls.append((fit.theory.vector - LAW) / np.sqrt(np.diag(fit.covariance)))
    # The standard deviation of 40 unit normals is 1 +- 0.11.
    assert np.std(pulls, axis=0) == pytest.approx([1, 1, 1], abs=0.4)
    assert np.mean(pulls, axis=0) == pytest.approx([0, 0, 0], abs=0.6)


def test_poses_and_a_table_of_the_same_shots_agree(tmp_path: Path) -> None:
    shots, seed = 40, 7
    data = campaign(shots, seed)
    poses = write_campaign(tmp_path / "poses", data)
    # The same draws as those of the campaign, so the same shots.
    drawn = draw(np.random.default_rng(seed), shots)
    written = write_contacts(tmp_path / "table", drawn, np.random.default_rng(8), LAW)
    of_poses = fit_campaign(without_contact_frames(gather_poses(poses)[1]))
    of_table = fit_campaign(table(written))
    apart = np.sqrt(np.diag(of_poses.covariance) + np.diag(of_table.covariance))
    assert (np.abs(of_poses.theory.vector - of_table.theory.vector) < 4 * apart).all()


def test_contacts_are_taken_before_poses_and_poses_can_still_be_had(tmp_path: Path) -> None:
    written = write_campaign(tmp_path, campaign(4, 3))
    assert not isinstance(gather(written)[1], ContactTable)
    contacts(tmp_path, 6, 4)
    assert len(table(tmp_path).shots) == 6
    assert gather_poses(tmp_path)[1].shots.tolist() == [1, 2, 3, 4]


def test_a_stage_that_is_named_is_taken_whatever_else_is_there(tmp_path: Path) -> None:
    write_campaign(tmp_path, campaign(4, 3))
    impacts(tmp_path, 5, 4)
    contacts(tmp_path, 6, 4)
    for file, shots in (("poses.csv", 4), ("impacts.csv", 5), ("contacts.csv", 6)):
        name, data = gather(tmp_path / file)
        assert (name, len(data.shots)) == ("hard spheres", shots)
    with pytest.raises(InputError, match=r"shots\.csv: is none of contacts\.csv, impacts\.csv and"):
        gather(tmp_path / "shots.csv")


def test_scalars_are_taken_before_poses_and_states_before_scalars(tmp_path: Path) -> None:
    write_campaign(tmp_path, campaign(4, 3))
    impacts(tmp_path, 5, 4)
    assert table(tmp_path).scalars
    contacts(tmp_path, 6, 4)
    assert not table(tmp_path).scalars


def test_a_table_foretells_what_is_left_out_as_well_as_its_noise_lets_it(tmp_path: Path) -> None:
    data = table(contacts(tmp_path, 60, 5))
    error = prediction_error(data, fit_campaign(data))
    assert error.value == pytest.approx(1.0, abs=5 * error.sampling)
    assert error.sampling == pytest.approx(np.sqrt(0.5 / (60 * 12)))


def test_the_state_after_is_foretold_worse_where_the_law_is_wrong(tmp_path: Path) -> None:
    data = table(contacts(tmp_path, 60, 5, slope=0.06))
    assert prediction_error(data, fit_campaign(data)).value > 1.3


def test_nothing_is_left_over_where_nothing_is_missing(tmp_path: Path) -> None:
    for seed, write in enumerate((contacts, impacts)):
        data = table(write(tmp_path / str(seed), 60, 20 + seed))
        cells = lack_of_fit(data, fit_campaign(data))
        assert cells[0].p_holm > 0.01
        assert not {cell.covariate for cell in cells} & {"time", "contact X", "field X"}


def test_channels_of_scalars_are_those_that_scalars_tell_of(tmp_path: Path) -> None:
    data = table(impacts(tmp_path, 20, 3))
    cells = lack_of_fit(data, fit_campaign(data))
    assert {cell.channel for cell in cells} == {"relative velocity n", "relative velocity t"}
    assert {cell.covariate for cell in cells} == {"ln v_n", "ln v_s/v_n", "order"}


def test_a_wild_shot_is_taken_out(tmp_path: Path) -> None:
    written = impacts(tmp_path, 40, 6)
    path = written / "impacts.csv"
    head, first, *rest = path.read_text(encoding="utf-8").splitlines()
    fields = first.split(",")
    fields[3] = str(float(fields[3]) + 0.3)
    path.write_text("\n".join([head, ",".join(fields), *rest]) + "\n", encoding="utf-8")
    cleaned = clean(table(written))
    assert cleaned.kept.tolist() == [False, *([True] * 39)]
    assert cleaned.frames == ()
    assert_law(cleaned.fit)


def test_five_shots_are_enough_to_say_something(tmp_path: Path) -> None:
    fit = fit_campaign(table(impacts(tmp_path, 5, 8)))
    assert fit.freedom == 7
    assert_law(fit)


def test_one_setting_leaves_open_what_it_does_not_show(tmp_path: Path) -> None:
    fit = fit_campaign(table(impacts(tmp_path, 12, 9, setting=(2.0, 3.0))))
    e, mu, beta0 = np.sqrt(np.diag(fit.covariance))
    assert (e, mu) == pytest.approx((0, 0), abs=0.01)
    # Every shot slides: of beta0 only its prior is known.
    assert beta0 == pytest.approx(0.7, rel=0.01)
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit.freedom))


def test_contacts_without_spins_tell_of_restitution_and_nothing_of_friction(tmp_path: Path) -> None:
    written = contacts(tmp_path, 60, 10)
    path = written / "contacts.csv"
    head, *lines = path.read_text(encoding="utf-8").splitlines()
    names = head.split(",")
    gone = {n for n in names if n.startswith("w")} | {"sigma_w_rad_per_s"}
    kept = [
        ",".join("" if n in gone else f for n, f in zip(names, line.split(","), strict=True))
        for line in lines
    ]
    path.write_text("\n".join([head, *kept]) + "\n", encoding="utf-8")
    data = table(written)
    fit = fit_campaign(data)
    # Six velocities after contact of each shot, less the two numbers of its kick.
    assert fit.freedom == 60 * (6 - 2) - 3
    assert fit.chi2_per_dof == pytest.approx(1.0, abs=4 * np.sqrt(2 / fit.freedom))
    found = fit.parameters()
    assert found["e"].value == pytest.approx(LAW[0], abs=4 * found["e"].sigma)
    assert found["e"].sigma < 0.001
    assert not found["mu"].determined


def test_errors_that_are_not_stated_are_taken_from_the_scatter(tmp_path: Path) -> None:
    scalars = table(impacts(tmp_path / "impacts", 80, 11, sigma=None, noise=0.02))
    assert scalars.estimated
    assert scalars.sigma[0] == pytest.approx(np.full(4, 0.02), rel=0.2)
    assert_law(fit_campaign(scalars))
    states = table(contacts(tmp_path / "contacts", 80, 12, stated=False, noise=3.0))
    assert states.estimated
    assert states.sigma[0, :3] == pytest.approx(3 * 0.004, rel=0.2)
    assert states.sigma[0, 6:9] == pytest.approx(3 * 0.4, rel=0.2)
    assert_law(fit_campaign(states))


def test_bad_spins_do_not_hide_good_velocities_where_no_errors_are_stated(tmp_path: Path) -> None:
    folder = contacts(tmp_path, 80, 21, stated=False)
    head, *lines = (folder / "contacts.csv").read_text().splitlines()
    rng, spins = np.random.default_rng(5), [n.startswith("w") for n in head.split(",")]
    worse = [
        ",".join(
            repr(float(field) + 8 * rng.normal()) if spin else field
            for field, spin in zip(line.split(","), spins, strict=True)
        )
        for line in lines
    ]
    (folder / "contacts.csv").write_text("\n".join([head, *worse]) + "\n", encoding="utf-8")
    found = table(folder)
    assert found.sigma[0, :3] == pytest.approx(0.004, rel=0.25)
    assert found.sigma[0, 6:9] == pytest.approx(8.0, rel=0.25)
    e = fit_campaign(found).parameters()["e"]
    assert e.sigma < 5e-4
    assert e.value == pytest.approx(LAW[0], abs=4 * e.sigma)


def test_each_number_of_a_contact_may_have_an_error_of_its_own(tmp_path: Path) -> None:
    folder = contacts(tmp_path, 3, 22)
    path = folder / "contacts.csv"
    head, *lines = path.read_text().splitlines()
    own = ["0.001", "", "0.3"]
    rows = [f"{line},{sigma}" for line, sigma in zip(lines, own, strict=True)]
    path.write_text("\n".join([f"{head},sigma_vb_y_after", *rows]) + "\n", encoding="utf-8")
    sigma = table(folder).sigma
    # vb_y_after is the fifth of the twelve after contact; where it has none, that of velocities.
    assert sigma[:, 12 + 4] == pytest.approx([0.001, 0.004, 0.3])
    assert (np.delete(sigma[:, :6], 4, axis=1) == 0.004).all()


def test_stated_errors_are_left_as_they_are(tmp_path: Path) -> None:
    data = table(impacts(tmp_path, 20, 13, sigma=0.03))
    assert not data.estimated
    assert np.unique(data.sigma).tolist() == [0.03]
    assert [scale.sigma for scale in noise_scales(data, fit_campaign(data))] == [np.inf, np.inf]


def test_a_table_that_fits_exactly_cannot_tell_its_noise(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no errors are stated, and the numbers fit the model"):
        gather(impacts(tmp_path, 20, 14, sigma=None, noise=0.0))


def test_too_few_numbers_cannot_tell_their_noise(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="4 numbers leave no scatter about 5 fitted ones"):
        gather(impacts(tmp_path, 1, 14, sigma=None))


def test_a_table_without_shots_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"impacts\.csv: holds no shots"):
        gather(impacts(tmp_path, 0, 14))


def test_a_surface_velocity_after_contact_tells_nothing_alone(tmp_path: Path) -> None:
    rows: list[list[object]] = [
        ["shot", "v_n", "v_s", "v_n_after", "v_s_after"],
        *([k, -1.0 - k, "", 0.7 * (1 + k) + 0.01 * (-1) ** k, 0.2] for k in range(6)),
    ]
    data = table(folder_with(tmp_path, "impacts.csv", rows, DESCRIPTION))
    assert data.measured.tolist() == [[True, False, True, False]] * 6
    assert fit_campaign(data).theory.law.e == pytest.approx(0.7, abs=0.01)


def test_a_covariate_of_the_shot_list_goes_with_its_shot(tmp_path: Path) -> None:
    written = impacts(tmp_path, 3, 15)
    (written / "shots.csv").write_text("shot,humidity\n3,30\n1,10\n2,20\n", encoding="utf-8")
    assert table(written).covariates["humidity"].tolist() == [10, 20, 30]


@pytest.mark.parametrize("write", [contacts, impacts])
def test_parts_of_a_table_are_the_table_of_these_shots(tmp_path: Path, write) -> None:
    data = table(write(tmp_path, 6, 16))
    for part in (data.part(slice(2, 4)), data.of_shots(np.array([0, 0, 1, 1, 0, 0], dtype=bool))):
        assert part.shots.tolist() == [3, 4]
        assert np.array_equal(part.numbers, data.numbers[2:4])
        assert np.array_equal(part.start.velocity_a, data.start.velocity_a[2:4])
        assert part.covariates["order"].tolist() == data.covariates["order"][2:4].tolist()


def test_a_plate_in_place_of_a_is_refused(tmp_path: Path) -> None:
    swapped = PLATE.replace('"a"', '"c"').replace('"b"', '"a"').replace('"c"', '"b"')
    with pytest.raises(InputError, match="a plate comes only as sphere b"):
        gather(impacts(tmp_path, 3, 17, description=swapped))


def test_a_plate_that_no_sphere_comes_near_is_refused_with_what_is_missing(tmp_path: Path) -> None:
    written = write_campaign(tmp_path, campaign(3, 18))
    # The spheres of this campaign fly in the plane of X and Y, along this plate.
    beside = PLATE.replace("plate = true", "plate = true\nnormal = [0.0, 0.0, 1.0]")
    (written / "campaign.toml").write_text(beside, encoding="utf-8")
    with pytest.raises(InputError, match="coming near a plate and leaving it"):
        gather(written)
