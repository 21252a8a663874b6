import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest
import tifffile
from rendered import setup_of, shot

from analysis import compiled
from analysis.document import overlay_document, shot_document
from analysis.errors import ShotRefusedError
from analysis.imaging.edge.frame import EdgeSettings
from analysis.imaging.files.stack import read_stack
from analysis.setup import Setup
from analysis.shot import AnalysisOptions, MeasuredShot, RefusedShot, analyse_shot
from simulators.world import RenderedShot, WorldDescription
from simulators.world.truth import FilmedTruth

SETUP = setup_of(WorldDescription())


@pytest.fixture(scope="module")
def rendered() -> RenderedShot:
    return shot(50.0, 8.0)


@pytest.fixture(scope="module")
def measured(rendered: RenderedShot) -> MeasuredShot:
    return found(analyse_shot(rendered.frames, rendered.times_s, SETUP))


def found(result: MeasuredShot | RefusedShot) -> MeasuredShot:
    assert isinstance(result, MeasuredShot), result
    return result


def refused(
    frames: np.ndarray, times_s: np.ndarray | None = None, setup: Setup = SETUP
) -> RefusedShot:
    times = np.arange(len(frames)) * 1e-3 if times_s is None else times_s
    result = analyse_shot(frames, times, setup)
    assert isinstance(result, RefusedShot), result
    assert not result
    return result


def assert_true(result: MeasuredShot, truth: FilmedTruth, *, share: float = 0.01) -> None:
    impact = result.impact
    assert impact.v_n.value == pytest.approx(truth["v_n"], rel=share)
    assert impact.v_n_after.value == pytest.approx(truth["v_n_after"], rel=share)
    assert impact.v_s.value == pytest.approx(truth["v_s"], abs=0.05)
    assert impact.v_s_after.value == pytest.approx(truth["v_s_after"], abs=0.08)
    assert impact.contact_time.value == pytest.approx(truth["contact_time_s"], abs=1e-4)
    assert float(impact.normal @ np.array(truth["normal"])) > np.cos(np.radians(0.5))


def test_a_rendered_shot_is_measured(measured: MeasuredShot, rendered: RenderedShot) -> None:
    assert_true(measured, rendered.truth)
    contact = rendered.truth["contact_time_s"]
    assert rendered.times_s[measured.used_before[-1]] < contact
    assert rendered.times_s[measured.used_after[0]] > contact
    assert len(measured.used_before) + len(measured.used_after) >= 17


@pytest.mark.parametrize("step", ["assignment", "motion", "contact"])
def test_a_shot_that_markers_refuse_is_measured_by_its_outlines(
    rendered: RenderedShot, step: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of spheres that turn far from frame to frame, whose markers are taken for others."""

    def lost(*_: object, **__: object) -> NoReturn:
        raise ShotRefusedError(step, "markers are lost")

    monkeypatch.setattr("analysis.photometric.method.measure_poses", lost)
    result = found(analyse_shot(rendered.frames, rendered.times_s, SETUP))
    assert "by its markers the shot is refused: markers are lost" in result.notes[0]
    e, v_n, truth = result.impact.e, result.impact.v_n, rendered.truth
    assert abs(e.value + truth["v_n_after"] / truth["v_n"]) < min(4.0 * e.sigma, 0.02)
    assert abs(v_n.value - truth["v_n"]) < min(4.0 * v_n.sigma, 0.02 * abs(truth["v_n"]))
    assert result.impact.v_s is None


@pytest.mark.long
def test_twelve_bits_are_measured_as_eight_are(
    measured: MeasuredShot,
    rendered: RenderedShot,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Bits below the eighth are drawn, so that they hold nothing: their rounding is noise.

    Nor is anything compiled once more for them.
    """
    below = np.random.default_rng(1).integers(0, 16, rendered.frames.shape)
    tifffile.imwrite(
        tmp_path / "0001.tiff", (16 * rendered.frames.astype(int) + below).astype(np.uint16)
    )
    stack = read_stack(tmp_path / "0001.tiff")
    assert stack.light.dtype == np.float32
    compiled_here: list[int] = []
    monkeypatch.setattr(compiled, "_listeners", [lambda done, _: compiled_here.append(done)])
    deep = found(analyse_shot(stack.light, rendered.times_s, SETUP))
    assert not compiled_here
    assert_true(deep, rendered.truth)
    for one, other in ((deep.impact.v_n, measured.impact.v_n), (deep.impact.e, measured.impact.e)):
        assert one.value == pytest.approx(other.value, abs=other.sigma)
        assert one.sigma == pytest.approx(other.sigma, rel=0.2)


def test_the_centres_of_every_frame_are_those_of_the_truth(
    measured: MeasuredShot, rendered: RenderedShot
) -> None:
    for i, sphere in enumerate(measured.tracking.spheres):
        for view, track in sphere.items():
            truth = rendered.truth[f"centres_{view.value}_px"]  # type: ignore[literal-required]
            errors = [np.subtract(track.centre(k), truth[k][i]) for k in track.outlines]
            assert len(errors) >= 18
            # Shading shifts a whole disc by some hundredths of a pixel; velocities do not see it.
            assert np.sqrt(np.mean(np.square(errors))) < 0.15


@pytest.mark.parametrize(
    ("options", "share"),
    [
        (AnalysisOptions(EdgeSettings(samples_per_pixel=4), method="thesis"), 0.01),
        (AnalysisOptions(EdgeSettings(sigma_px=1.0), method="thesis"), 0.01),
        (AnalysisOptions(three_and_three=True), 0.06),
    ],
    ids=["four samples a pixel", "narrow filter", "three and three"],
)
def test_each_way_of_the_thesis_measures_the_same_shot(
    rendered: RenderedShot, options: AnalysisOptions, share: float
) -> None:
    result = found(analyse_shot(rendered.frames, rendered.times_s, SETUP, options))
    assert result.impact.v_n.value == pytest.approx(rendered.truth["v_n"], rel=share)
    assert result.impact.v_n_after.value == pytest.approx(rendered.truth["v_n_after"], rel=share)


def test_markers_matched_from_frame_to_frame_measure_the_same_shot() -> None:
    # Front view only: four markers in sight on average, so not every shot can be done this way.
    plain = shot(50.0, 8.0, seed=1)
    options = AnalysisOptions(matching="proximal", method="thesis")
    assert_true(found(analyse_shot(plain.frames, plain.times_s, SETUP, options)), plain.truth)


def test_three_and_three_takes_frames_two_milliseconds_apart(rendered: RenderedShot) -> None:
    options = AnalysisOptions(three_and_three=True)
    result = found(analyse_shot(rendered.frames, rendered.times_s, SETUP, options))
    for used in (result.used_before, result.used_after):
        assert np.diff(used).tolist() == [2, 2]


def test_without_a_top_view_z_is_constant_and_the_spins_show_the_tilt(
    rendered: RenderedShot,
) -> None:
    camera = replace(SETUP.camera, top_view_rows=None, top_origin_px=None)
    frames = rendered.frames.copy()
    frames[:, : camera.front_view_rows[0] - 1] = 34
    result = found(analyse_shot(frames, rendered.times_s, replace(SETUP, camera=camera)))
    assert not result.centres[0].position[:, 2].any()
    off = result.impact.normal[2] - rendered.truth["normal"][2]
    assert abs(off) < 3.0 * result.impact.normal_sigma[2]
    assert result.impact.v_n.value == pytest.approx(rendered.truth["v_n"], rel=0.02)


def test_without_a_scale_it_is_taken_from_the_spheres(rendered: RenderedShot) -> None:
    setup = replace(SETUP, camera=replace(SETUP.camera, scale_px_per_m=None))
    result = found(analyse_shot(rendered.frames, rendered.times_s, setup))
    for scale in result.tracking.scales_px_per_m.values():
        assert scale == pytest.approx(1574.8, rel=0.01)
    assert result.tracking.scale_sigma > 0.0
    assert result.impact.v_n.value == pytest.approx(rendered.truth["v_n"], rel=0.015)


def test_velocities_err_by_the_diameters_that_lengths_are_measured_by(
    rendered: RenderedShot,
) -> None:
    camera = replace(SETUP.camera, scale_px_per_m=None)

    def with_diameters(sigma_m: float) -> MeasuredShot:
        a, b = (replace(sphere, diameter_sigma_m=sigma_m) for sphere in SETUP.spheres)
        setup = replace(SETUP, camera=camera, spheres=(a, b))
        return found(analyse_shot(rendered.frames, rendered.times_s, setup))

    exact, rough = with_diameters(0.0).impact.v_n, with_diameters(0.254e-3).impact.v_n
    assert rough.value == exact.value
    # Lengths that are 1 % uncertain leave 1 % of v_n beside all else, for a head-on shot.
    added = np.sqrt(rough.sigma**2 - exact.sigma**2) / abs(exact.value)
    obliquity = (rendered.truth["v_s"] / rendered.truth["v_n"]) ** 2
    assert added == pytest.approx(0.01 * abs(1.0 - obliquity), rel=0.1)


def test_lost_frames_leave_a_gap_in_time_and_nothing_else(rendered: RenderedShot) -> None:
    kept = np.delete(np.arange(20), [4, 13, 14])
    result = found(analyse_shot(rendered.frames[kept], rendered.times_s[kept], SETUP))
    assert_true(result, rendered.truth)


def test_times_may_begin_at_any_moment(measured: MeasuredShot, rendered: RenderedShot) -> None:
    result = found(analyse_shot(rendered.frames, rendered.times_s + 812.0, SETUP))
    shown = shot_document(result)
    contact = measured.impact.contact_time.value
    assert shown["contact_time_s"] == pytest.approx(contact, abs=1e-6)
    assert result.impact.v_n.value == pytest.approx(measured.impact.v_n.value, rel=1e-6)


def test_exchanged_sides_exchange_the_names(rendered: RenderedShot) -> None:
    mirrored = np.ascontiguousarray(rendered.frames[:, :, ::-1])
    camera = SETUP.camera
    row, column = camera.front_origin_px or (0.0, 0.0)
    top = camera.top_origin_px or (0.0, 0.0)
    swapped = replace(
        camera, front_origin_px=(row, 239.0 - column), top_origin_px=(top[0], 239.0 - column)
    )
    result = found(analyse_shot(mirrored, rendered.times_s, replace(SETUP, camera=swapped)))
    assert result.impact.v_n.value == pytest.approx(rendered.truth["v_n"], rel=0.01)
    # Mirrored, the normal from the left sphere to the right keeps its Y and turns X and Z.
    x, y, z = rendered.truth["normal"]
    np.testing.assert_allclose(result.impact.normal, (-x, y, -z), atol=0.01)


def with_times(values: list[float]) -> np.ndarray:
    return np.array(values) * 1e-3


@pytest.mark.parametrize(
    ("frames", "times", "said"),
    [
        (np.zeros((8, 100, 240), np.uint8), None, "100 x 240 pixels .* set up for 192 x 240"),
        (np.zeros((8, 192, 240), np.uint16), None, "uint16; grey frames"),
        (np.zeros((192, 240), np.uint8), None, r"\(192, 240\).*grey frames"),
        (np.zeros((5, 192, 240), np.uint8), None, "5 frames; at least 6"),
        (np.zeros((8, 192, 240), np.uint8), with_times([0, 1, 2]), "3 times for 8 frames"),
    ],
)
def test_frames_of_the_wrong_kind_are_refused_with_what_is_needed(
    frames: np.ndarray, times: np.ndarray | None, said: str
) -> None:
    result = refused(frames, times)
    assert result.step == "frames"
    assert result.frame is None
    assert re.search(said, result.reason), result.reason


@pytest.mark.parametrize(
    ("times", "frame"),
    [
        ([0, 1, 2, 2, 4, 5, 6, 7], 3),
        ([0, 1, 2, 3, 4, 3.5, 6, 7], 5),
        ([0, 1, 2, 3, 4, 5, float("nan"), 7], 6),
    ],
)
def test_times_that_do_not_increase_name_the_frame(times: list[float], frame: int) -> None:
    result = refused(np.zeros((8, 192, 240), np.uint8), with_times(times))
    assert (result.step, result.frame) == ("frames", frame)


@pytest.mark.parametrize("scale", [1574.8, None])
def test_blank_frames_are_refused(scale: float | None) -> None:
    noise = 2.0 * np.random.default_rng(1).standard_normal((8, 192, 240))
    blank = np.clip(np.rint(40 + noise), 0, 255).astype(np.uint8)
    setup = replace(SETUP, camera=replace(SETUP.camera, scale_px_per_m=scale))
    assert refused(blank, setup=setup).step in {"outlines", "assignment"}


def test_one_sphere_only_is_refused_with_what_was_seen(rendered: RenderedShot) -> None:
    frames = rendered.frames.copy()
    frames[:, :, 118:] = frames[:, :, :1]
    result = refused(frames[:8])
    assert result.step == "assignment"
    assert "1 of 2 in the front view and 1 of 2 in the top view" in result.reason
    assert result.frame is not None


def test_frames_that_end_before_the_contact_are_refused() -> None:
    early = shot(50.0, 8.0, frames=32)
    contact = int(early.truth["contact_time_s"] * 1e3)
    result = refused(early.frames[3 : contact - 1])
    assert result.step in {"contact", "assignment"}
    assert result.step == "contact", result


def test_two_frames_after_the_contact_are_too_few(rendered: RenderedShot) -> None:
    contact = int(rendered.truth["contact_time_s"] * 1e3)
    result = refused(rendered.frames[: contact + 3])
    assert result.step == "contact"


def test_spheres_that_pass_each_other_by_are_refused() -> None:
    missed = shot(50.0, 27.5)
    assert missed.truth["missed"]
    result = refused(missed.frames)
    assert result.step in {"contact", "assignment"}


def test_a_refusal_s_document_says_step_frame_and_reason(rendered: RenderedShot) -> None:
    result = refused(rendered.frames[:4])
    assert shot_document(result) == {
        "status": "refused",
        "step": "frames",
        "reason": "4 frames; at least 6 are needed",
    }
    placed = shot_document(RefusedShot("markers", "only 2", 7))
    assert placed["frame"] == 7


def test_the_document_is_json_without_nan_and_agrees_with_the_shot(
    measured: MeasuredShot,
) -> None:
    document = json.loads(json.dumps(shot_document(measured), allow_nan=False))
    assert document["status"] == "measured"
    assert document["e"]["value"] == measured.impact.e.value
    assert document["v_n"]["unit"] == "m/s"
    assert document["v_n"]["value"] < 0 < document["v_n_after"]["value"]
    assert document["e"]["value"] == pytest.approx(
        -document["v_n_after"]["value"] / document["v_n"]["value"]
    )
    assert np.linalg.norm(document["normal"]) == pytest.approx(1.0)
    assert set(document["scale_px_per_m"]) == {"front", "top"}


def test_the_overlay_document_has_every_frame_and_is_json(
    measured: MeasuredShot, rendered: RenderedShot
) -> None:
    frames = json.loads(
        json.dumps(overlay_document(measured.tracking, len(measured.times_s)), allow_nan=False)
    )
    assert [frame["frame"] for frame in frames] == list(range(20))
    named = 0
    for k, frame in enumerate(frames):
        for outline in frame["outlines"]:
            i = "ab".index(outline["sphere"])
            key = f"centres_{outline['view']}_px"
            row, column = rendered.truth[key][k][i]  # type: ignore[literal-required]
            assert abs(outline["row"] - row) < 0.6
            assert abs(outline["column"] - column) < 0.6
        for marker in frame["markers"]:
            assert marker["sphere"] in {"a", "b"}
            named += marker["marker"] is not None
    assert named > 100


@pytest.mark.parametrize("options", [{"edges": EdgeSettings()}, {"matching": "pattern"}])
def test_rendering_has_no_edges_to_choose(options: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="mean nothing to the photometric method"):
        AnalysisOptions(**options)
