"""Every mistake in a configuration is named: file, field, value, limit."""

from __future__ import annotations

import copy
import datetime
import math
import re
import tomllib
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rigctl.config import Configuration, default_path, faults_of, load, parse
from rigctl.config.bench import load_bench
from rigctl.errors import ConfigurationError

ROOT = Path(__file__).parents[3]
BENCHES = [ROOT / f"config/simulated-{name}.toml" for name in ("disk", "stage")]
EXAMPLES = sorted({*(ROOT / "config").glob("*.toml")} - {*BENCHES})
SIMULATED = tomllib.loads((ROOT / "config" / "simulated.toml").read_text())
RELEASE = tomllib.loads((ROOT / "config" / "release.toml").read_text())


def changed(base: dict, path: str, value: object) -> dict:
    """Return a copy with one field set, or removed where the value is Ellipsis."""
    document = copy.deepcopy(base)
    *sections, field = path.split(".")
    here = document
    for section in sections:
        here = here[int(section)] if section.isdigit() else here[section]
    if value is ...:
        del here[field]
    else:
        here[int(field) if field.isdigit() else field] = value
    return document


def refusal(document: dict) -> ConfigurationError:
    with pytest.raises(ConfigurationError) as caught:
        parse(document, "rig.toml")
    return caught.value


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_each_example_is_a_valid_configuration_under_its_own_name(path: Path) -> None:
    assert load(path).name == path.stem


@pytest.mark.parametrize("path", BENCHES, ids=lambda path: path.stem)
def test_each_example_of_a_stage_or_a_disk_is_valid_under_its_own_name(path: Path) -> None:
    assert load_bench(path).name == path.stem


@pytest.mark.parametrize(
    ("section", "found"),
    [
        ("apparatus", "neither slide nor stage"),
        ("slide.port", "must begin with 'sim:'"),
        ("stage.steps", "at most 100"),
    ],
)
def test_a_stage_that_cannot_be_is_refused_with_the_field(
    tmp_path: Path, section: str, found: str
) -> None:
    wrong = {"apparatus": '"disk"', "slide.port": '"/dev/ttyUSB0"', "stage.steps": "101"}
    field = section.rpartition(".")[2]
    lines = (ROOT / "config" / "simulated-stage.toml").read_text().splitlines()
    part = [
        f"{field} = {wrong[section]}" if line.startswith(f"{field} =") else line for line in lines
    ]
    if field == "port":
        first = next(n for n, line in enumerate(lines) if line.startswith("port ="))
        part = [*part[: first + 1], *lines[first + 1 :]]
    (tmp_path / "stage.toml").write_text("\n".join(part))
    with pytest.raises(ConfigurationError, match=re.escape(found)):
        load_bench(tmp_path / "stage.toml")


def test_without_a_path_the_simulated_rig_is_loaded() -> None:
    assert load().simulation is not None
    assert default_path().name == "simulated.toml"


def test_an_example_is_simulated_where_its_name_says_so() -> None:
    for path in EXAMPLES:
        assert (load(path).simulation is not None) == path.stem.startswith("simulated")


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("limits.cool_down_s", "3", ["limits.cool_down_s", "'3'", "number"]),
        ("limits.cool_down_s", True, ["limits.cool_down_s", "(found True)"]),
        ("limits.cool_down_s", -1.0, ["limits.cool_down_s", "-1.0", "at least 0"]),
        ("limits.free_disk_mb", math.nan, ["limits.free_disk_mb", "finite"]),
        ("limits.settle_timeout_s", math.inf, ["limits.settle_timeout_s", "finite"]),
        ("limits.settle_timeout_s", 0.0, ["limits.settle_timeout_s", "more than 0"]),
        ("limits.pressure_kpa", [9.0, 1.0], ["limits.pressure_kpa", "[9.0, 1.0]", "lower"]),
        ("limits.pressure_kpa", [9.0], ["limits.pressure_kpa[1]", "missing"]),
        ("limits.pressure", 3.0, ["unknown key limits.pressure", "3.0", "take it out"]),
        ("limits.offset_mm", ..., ["limits.offset_mm", "missing", "add it"]),
        ("trigger.driver", "gun", ["trigger.driver", "'gun'", "trigger-box"]),
        ("trigger.driver", ..., ["trigger.driver", "missing"]),
        ("trigger.pulse_us", 1.5, ["trigger.pulse_us", "1.5", "integer"]),
        ("trigger.pulse_us", ..., ["trigger.pulse_us", "missing"]),
        ("trigger.power_cut", "fires", ["trigger.power_cut", "'fires'", "'holds'"]),
        ("camera.frame_rate_hz", 100, ["camera.frame_rate_hz", "100", "1000"]),
        ("camera.pictures_per_frame", 5, ["camera.pictures_per_frame", "5", "6"]),
        ("camera.pictures_per_frame", 2, ["camera", "96 rows", "192"]),
        ("camera.recorder.answer_timeout_s", 0, ["camera.recorder.answer_timeout_s", "more"]),
        ("camera.source.folder", "", ["camera.source.folder", "at least 1"]),
        ("regulator.unit_a", "B", ["regulator", "unit_a and unit_b"]),
        ("regulator", ..., ["pusher apparatus needs regulator and slide"]),
        ("service.port", 70000, ["service.port", "70000", "at most 65535"]),
        ("analysis.method", "guess", ["analysis.method", "'guess'", "thesis"]),
        ("optics.top_view_rows", [0, 100], ["optics", "overlap"]),
        ("optics.front_view_rows", [88, 300], ["front_view_rows", "300", "192"]),
        ("spheres.1.density_kg_per_m3", True, ["spheres[1].density_kg_per_m3", "True"]),
        ("spheres.1.inertia_factor", 0.7, ["spheres[1].inertia_factor", "0.7", "at most 0.66"]),
        ("spheres.1.name", "a", ["spheres", "both are named 'a'"]),
        ("spheres.1", 3, ["spheres[1]", "3"]),
        ("simulation.factory", "os.system", ["simulation.factory", "os.system"]),
        ("name", datetime.date(2020, 1, 1), ["2020-01-01"]),
        ("apparatus", "release", ["release apparatus"]),
    ],
)
def test_a_mistake_is_one_sentence_with_file_field_value_and_limit(
    path: str, value: object, words: list[str]
) -> None:
    sentence = str(refusal(changed(SIMULATED, path, value)))
    assert "\n" not in sentence
    assert all(word in sentence for word in words), sentence


def test_the_file_is_named() -> None:
    assert refusal(changed(SIMULATED, "name", 3)).part == "rig.toml: name"


def test_further_mistakes_are_named_too() -> None:
    twice = changed(changed(SIMULATED, "service.port", -1), "camera.rows", "many")
    assert "service.port" in str(refusal(twice))
    assert "camera.rows" in str(refusal(twice))
    misspelt = changed(changed(SIMULATED, "store.foldr", "a"), "service.prot", 1)
    assert sorted(re.findall(r"unknown key (\S+)", str(refusal(misspelt)).replace(",", " "))) == [
        "service.prot",
        "store.foldr",
    ]


def test_a_key_that_is_missing_elsewhere_is_not_taken_for_the_one_that_is_misspelt() -> None:
    slipped = changed(changed(SIMULATED, "trigger.port", ...), "trigger.prt", "sim:trigger")
    document = changed(slipped, "regulator.port", ...)
    said = [str(fault) for fault in faults_of(Configuration, document, "rig.toml")]
    assert len(said) == 2
    assert "unknown key trigger.prt" in said[0]
    assert "regulator.port: is missing" in said[1]


@pytest.mark.parametrize("section", ["trigger", "regulator", "slide", "cut_off"])
def test_a_simulated_rig_holds_no_real_port(section: str) -> None:
    sentence = str(refusal(changed(SIMULATED, f"{section}.port", "/dev/ttyUSB0")))
    assert f"{section}.port" in sentence
    assert "must begin with 'sim:'" in sentence


def test_without_the_simulation_table_no_port_is_simulated() -> None:
    assert "must not begin with 'sim:'" in str(refusal(changed(SIMULATED, "simulation", ...)))


def test_the_emergency_stop_has_a_line_of_its_own() -> None:
    shared = changed(RELEASE, "cut_off.port", RELEASE["trigger"]["port"])
    assert "cut_off.port and trigger.port share" in str(refusal(shared))


@pytest.mark.parametrize(
    ("energised", "power_cut", "valid"),
    [
        ("hold", "fires", True),
        ("hold", "holds", False),
        ("release", "holds", True),
        ("release", "fires", False),
    ],
)
def test_what_a_power_cut_does_must_agree_with_what_the_solenoid_does(
    energised: str, power_cut: str, valid: bool
) -> None:
    document = changed(RELEASE, "trigger.energised", energised)
    document = changed(document, "trigger.power_cut", power_cut)
    if valid:
        assert parse(document, "rig.toml").trigger.power_cut == power_cut
    else:
        assert "power_cut" in str(refusal(document))


@pytest.mark.parametrize("field", ["energised", "power_cut"])
def test_the_polarity_of_a_solenoid_is_never_assumed(field: str) -> None:
    assert f"trigger.{field}" in str(refusal(changed(RELEASE, f"trigger.{field}", ...)))


def test_a_plate_may_take_the_place_of_sphere_b() -> None:
    document = changed(SIMULATED, "spheres.1", {"name": "b", "plate": True})
    assert parse(document, "rig.toml").spheres[1].plate is True


def test_options_of_the_simulation_are_handed_on_as_they_are() -> None:
    document = changed(SIMULATED, "simulation.weather", "fine")
    assert parse(document, "rig.toml").simulation.options == {"seed": 1, "weather": "fine"}


def test_the_digest_changes_with_any_field_and_with_nothing_else() -> None:
    first = parse(SIMULATED, "a.toml").digest
    assert first == parse(copy.deepcopy(SIMULATED), "b.toml").digest
    assert first != parse(changed(SIMULATED, "limits.cool_down_s", 0.3), "a.toml").digest


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"absent\.toml"):
        load(tmp_path / "absent.toml")


@pytest.mark.parametrize("content", [b"name = ", b"\xff\xfe", b"[a]\n[a]\n"])
def test_a_file_that_is_not_toml_is_named(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "broken.toml"
    path.write_bytes(content)
    with pytest.raises(ConfigurationError, match=r"broken\.toml.*not TOML"):
        load(path)


def leaves(value: object, path: str = "") -> list[str]:
    if isinstance(value, dict):
        return [leaf for key, item in value.items() for leaf in leaves(item, f"{path}.{key}")]
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [leaf for i, item in enumerate(value) for leaf in leaves(item, f"{path}.{i}")]
    return [path.lstrip(".")]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=4,
)


@given(path=st.sampled_from(leaves(SIMULATED)), value=JSON)
def test_whatever_stands_in_a_field_it_is_either_valid_or_a_configuration_error(
    path: str, value: object
) -> None:
    document = changed(SIMULATED, path, value)
    with suppress(ConfigurationError):
        assert parse(document, "rig.toml").model_dump(mode="json")


@given(path=st.sampled_from([leaf for leaf in leaves(SIMULATED) if "simulation" not in leaf]))
def test_a_misspelt_field_is_refused_by_its_name(path: str) -> None:
    document = changed(SIMULATED, f"{path}x", 1)
    assert f"{path.rpartition('.')[2]}x" in str(refusal(document))


@pytest.mark.parametrize(
    ("path", "slip"),
    [
        ("trigger.pulse_us", "pluse_us"),
        ("limits.cool_down_s", "cooldown_s"),
        ("camera.recorder.answer_timeout_s", "answer_time_out_s"),
        ("camera.remote_trigger.channel", "chanel"),
        ("spheres.1.diameter_m", "diametre_m"),
        ("environment.gravity_m_per_s2", "gravity_m_per_s"),
        ("optics.front_view_rows", "front_view_row"),
        ("trigger", "triger"),
    ],
)
def test_a_slip_in_a_key_is_called_unknown_first_and_the_key_that_was_meant_is_named(
    path: str, slip: str
) -> None:
    *sections, key = path.split(".")
    document = changed(SIMULATED, path, ...)
    document = changed(document, ".".join([*sections, slip]), 20000)
    written = re.sub(r"\.(\d)", r"[\1]", ".".join([*sections, slip]))
    sentence = str(refusal(document))
    said = f"rig.toml: unknown key {written} (found 20000); did you mean {key}?"
    assert sentence.startswith(said)
    assert "missing" not in sentence


def test_a_key_of_another_driver_is_not_what_was_meant() -> None:
    slipped = changed(RELEASE, "trigger.pulse_uss", 20000)
    assert "did you mean" not in str(refusal(slipped))


def test_a_key_that_is_there_already_is_not_what_was_meant() -> None:
    doubled = changed(SIMULATED, "trigger.pulse_uss", 20000)
    assert "did you mean" not in str(refusal(doubled))
