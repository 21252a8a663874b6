from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from analysis.errors import InputError
from analysis.exchange.description import description, read_description
from analysis.setup import CameraSetup, Environment, Setup, SlowErrors, SphereSetup

WHOLE = """\
format = 1
name = "nylon-2"
[camera]
frame_rate_hz = 1000.0
width_px = 240
height_px = 192
scale_px_per_m = 1574.8
front_view_rows = [88, 192]
top_view_rows = [0, 88]
front_origin_px = [132.0, 120.0]
top_origin_px = [46.0, 120.0]
[[spheres]]
name = "b"
diameter_m = 0.0254
density_kg_per_m3 = 1140.0
inertia_factor = 0.4
[[spheres]]
name = "a"
diameter_m = 0.02
[environment]
gravity_m_per_s2 = 9.81
air_density_kg_per_m3 = 1.1
"""
LEAST = """\
format = 1
name = "bare"
camera = { frame_rate_hz = 500, width_px = 240, height_px = 192 }
spheres = [{ name = "a", diameter_m = 0.0254 }, { name = "b", plate = true }]
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "campaign.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_field_of_a_whole_description_is_read(tmp_path: Path) -> None:
    assert read_description(written(tmp_path, WHOLE)) == (
        "nylon-2",
        Setup(
            CameraSetup(
                1000.0, 192, 240, (88, 192), (0, 88), 1574.8, (132.0, 120.0), (46.0, 120.0)
            ),
            (SphereSetup("a", 0.02), SphereSetup("b", 0.0254, 1140.0, 0.4)),
            Environment(9.81, 1.1),
        ),
    )


def test_what_is_left_out_has_the_format_s_defaults(tmp_path: Path) -> None:
    _, setup = read_description(written(tmp_path, LEAST))
    assert setup.camera == CameraSetup(500.0, 192, 240, (0, 192), None)
    assert setup.spheres[1].plate
    assert setup.environment == Environment(9.80665, 1.2, None)


def test_a_drag_coefficient_without_an_error_is_known_to_0_2(tmp_path: Path) -> None:
    text = WHOLE.replace("[environment]", "[environment]\ndrag_coefficient = 0.42")
    _, setup = read_description(written(tmp_path, text))
    air = setup.environment
    assert (air.drag_coefficient, air.drag_coefficient_sigma) == (0.42, 0.2)


@pytest.mark.parametrize(
    ("change", "key", "value"),
    [
        (("width_px = 240", "width_px = 240\nwidht_px = 3"), "camera.widht_px", "3"),
        (("frame_rate_hz = 1000.0", 'frame_rate_hz = "fast"'), "camera.frame_rate_hz", "fast"),
        (("frame_rate_hz = 1000.0", "frame_rate_hz = 0.0"), "camera.frame_rate_hz", "0.0"),
        (("frame_rate_hz = 1000.0", "frame_rate_hz = inf"), "camera.frame_rate_hz", "inf"),
        (("frame_rate_hz = 1000.0\n", ""), "camera.frame_rate_hz", "is missing"),
        (("width_px = 240", "width_px = true"), "camera.width_px", "True"),
        (("width_px = 240", "width_px = 4"), "camera.width_px", "found 4, allowed at least 8"),
        (("width_px = 240", "width_px = 240.0"), "camera.width_px", "not a whole number"),
        (("[0, 88]", "[0, 88, 192]"), "camera.top_view_rows", "allowed 2 entries"),
        (("[0, 88]", "[0, 89]"), "camera.top_view_rows: [0, 89] overlaps", "[88, 192]"),
        (
            ("front_view_rows = [88, 192]\n", ""),
            "camera.top_view_rows",
            "overlaps",
        ),
        (("inertia_factor = 0.4", "inertia_factor = 0.7"), "inertia_factor", "at most 0.667"),
        (("inertia_factor = 0.4", "inertia_factor = 0.0"), "inertia_factor", "more than 0"),
        (("diameter_m = 0.02\n", "diameter_m = 25.4\n"), "diameter_m", "25.4 mm are 0.0254"),
        (("diameter_m = 0.02\n", "diameter_m = 1.1\n"), "diameter_m", "at most 1"),
        (("diameter_m = 0.02\n", 'diameter_m = "1 in"\n'), "diameter_m", "not a number"),
        (("[environment]", "[surroundings]"), "surroundings", "is not a key"),
        (("[132.0, 120.0]", "[132.0]"), "camera.front_origin_px", "132.0"),
        (('name = "nylon-2"', 'name = ""'), "name", "''"),
        (("diameter_m = 0.02\n", "diameter_m = -0.02\n"), "spheres.1.diameter_m", "-0.02"),
        (("diameter_m = 0.02\n", ""), "diameter_m", "'a'"),
        (('name = "b"', 'name = "c"'), "spheres.0.name", "'c'"),
        (('name = "b"', 'name = "a"'), "spheres", "'a'"),
        (("[0, 88]", "[0, 193]"), "camera.top_view_rows", "[0, 193]"),
        (("[88, 192]", "[100, 88]"), "camera.front_view_rows", "[100, 88]"),
        (("air_density_kg_per_m3 = 1.1", "air_density_kg_per_m3 = -1"), "air_density", "-1"),
        (("[environment]", "[environment]\ndrag_coefficient = -0.1"), "drag_coefficient", "-0.1"),
        (("format = 1", "format = 2"), "format", "2"),
        (("format = 1\n", ""), "format: is missing", ""),
        (("[camera]", "[camera"), "not TOML", "line 3"),
    ],
)
def test_a_mistake_is_named_with_file_key_and_value(
    tmp_path: Path, change: tuple[str, str], key: str, value: str
) -> None:
    assert change[0] in WHOLE
    path = written(tmp_path, WHOLE.replace(*change))
    with pytest.raises(InputError) as fault:
        read_description(path)
    assert fault.value.path == str(path)
    assert key in fault.value.reason
    assert value in fault.value.reason


def test_all_faults_of_a_file_are_named_at_once_with_unknown_keys(tmp_path: Path) -> None:
    text = WHOLE.replace("frame_rate_hz", "framerate_hz").replace("width_px = 240", "width_px = 4")
    path = written(tmp_path, text.replace("= 1140.0", "= -1.0"))
    with pytest.raises(InputError) as fault:
        read_description(path)
    assert set(fault.value.reason.split("; ")) == {
        "camera.frame_rate_hz: is missing",
        "camera.framerate_hz: is not a key of this table (found 1000.0)",
        "camera.width_px: is out of range (found 4, allowed at least 8)",
        "spheres.0.density_kg_per_m3: is out of range (found -1.0, allowed more than 0)",
    }


@pytest.mark.parametrize("text", ["", "\n", "# nothing yet\n", "\ufeff"])
def test_an_empty_file_is_called_empty(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError, match="is empty"):
        read_description(written(tmp_path, text))


def test_a_byte_order_mark_is_passed_over(tmp_path: Path) -> None:
    plain = read_description(written(tmp_path, WHOLE))
    assert read_description(written(tmp_path, "\ufeff" + WHOLE)) == plain


def test_a_folder_in_the_place_of_the_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_description(tmp_path)


def test_rows_at_fault_themselves_are_not_said_to_overlap(tmp_path: Path) -> None:
    path = written(tmp_path, WHOLE.replace("[88, 192]", "[88, 193]"))
    with pytest.raises(InputError) as fault:
        read_description(path)
    assert "front_view_rows: [88, 193]" in fault.value.reason
    assert "overlaps" not in fault.value.reason


def test_a_newer_format_says_both_versions(tmp_path: Path) -> None:
    path = written(tmp_path, WHOLE.replace("format = 1", "format = 7"))
    with pytest.raises(InputError, match=r"format 7; this program reads format 1"):
        read_description(path)


def test_an_absent_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"campaign\.toml: no such file"):
        read_description(tmp_path / "campaign.toml")


PAIR = (SphereSetup("a", 0.0254), SphereSetup("b", 0.0254))
front_rows = st.tuples(st.integers(90, 140), st.integers(141, 192))
top_rows = st.tuples(st.integers(0, 40), st.integers(41, 90))
pixels = st.tuples(st.floats(-500, 500), st.floats(-500, 500))
positive = st.floats(1e-6, 1e6)
setups = st.builds(
    Setup,
    camera=st.builds(
        CameraSetup,
        frame_rate_hz=positive,
        height_px=st.just(192),
        width_px=st.integers(16, 4096),
        front_view_rows=front_rows,
        top_view_rows=st.none() | top_rows,
        scale_px_per_m=st.none() | positive,
        front_origin_px=st.none() | pixels,
        top_origin_px=st.none() | pixels,
    ),
    spheres=st.tuples(
        *(
            st.builds(
                SphereSetup,
                name=st.just(name),
                diameter_m=st.floats(1e-6, 0.5),
                density_kg_per_m3=st.floats(1e-6, 30_000),
                inertia_factor=st.floats(1e-6, 2 / 3),
            )
            for name in "ab"
        )
    ),
    environment=st.builds(
        Environment,
        gravity_m_per_s2=st.floats(-100, 100),
        air_density_kg_per_m3=st.floats(0, 2000),
        drag_coefficient=st.none() | st.floats(0, 10),
        drag_coefficient_sigma=st.floats(0, 10),
    ),
    measurement=st.builds(
        SlowErrors,
        position_m=st.floats(0, 1),
        rotation_rad=st.floats(0, 1),
        shared_m=st.floats(0, 1),
        scale=st.floats(0, 1),
        one_body_frame=st.booleans(),
        memory_rad=positive,
    ),
)


@settings(max_examples=40, deadline=None)
@given(name=st.text(min_size=1, max_size=20), setup=setups)
@example(name='a "quoted" \x7f\n\U00010000', setup=Setup(CameraSetup(1.0, 192, 240), PAIR))
def test_a_written_description_reads_back_equal(
    tmp_path_factory: pytest.TempPathFactory, name: str, setup: Setup
) -> None:
    path = written(tmp_path_factory.getbasetemp(), description(name, setup))
    assert read_description(path) == (name, setup)
