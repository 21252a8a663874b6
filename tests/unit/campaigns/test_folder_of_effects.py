"""Effects of the user's own where the daemon asks for them: ranked like all, faults named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rigctl.config import Configuration, load
from rigctl.errors import AnalysisInputError, ConfigurationError, NotFoundError
from rigctl.measuring.measured import measured_files, request
from rigctl.model.computing import fit_job, ranking_job
from rigctl.model.known_effects import available, effect_document, effect_named
from rigctl.model.own_effects import OwnEffects, reading_job
from rigctl.store import Store
from tests.unit.analysis.effects.own_files import HERE, line_here, text_of, write

Keep = Callable[..., list[str]]

SAME_AS_PIXEL_ASPECT = """\
def appear(position, camera, values):
    return position * (1.0 + values[0] * np.array([1.0, 0.0, 1.0]))"""
FAILS_ON_REAL_SHOTS = f"""\
def appear(position, camera, values):
    if position.shape[0] == 4:
        raise ValueError("four shots are too few")  {HERE}
    return position * (1.0 + values[0])"""
UNFINISHED = f"def appear(position, camera, values:  {HERE}\n    return position\n"


def silent(text: str, share: float | None) -> None:
    """Hear how far a job is."""


@pytest.fixture
def effects(tmp_path: Path) -> Path:
    """Return a folder with one effect, which is one of the catalogue by another name."""
    write(tmp_path / "effects", text_of(SAME_AS_PIXEL_ASPECT, name="stretch"), "stretch")
    return tmp_path / "effects"


def configured(folder: Path) -> Configuration:
    configuration = load()
    analysis = configuration.analysis.model_copy(update={"effects": str(folder)})
    return configuration.model_copy(update={"analysis": analysis})


def test_an_own_effect_stands_beside_its_twin_of_the_catalogue_with_the_same_numbers(
    store: Store, keep: Keep, effects: Path
) -> None:
    keep()
    asked = request("nylon", measured_files(store, "nylon")) | {"own": str(effects)}
    ranked = ranking_job(asked, silent)
    found = {candidate["effect"]: candidate for candidate in ranked["candidates"]}
    twin, own = found["pixel-aspect"], found["stretch"]
    for number in ("promised_fall", "p_value", "p_familywise", "amplitude"):
        assert own[number] == pytest.approx(twin[number], rel=1e-3), number
    assert abs(own["score"]) == pytest.approx(abs(twin["score"]), rel=1e-3)
    assert "pixel-aspect" in own["like"]
    [said] = ranked["own"]
    assert (said["effect"], said["formula"]) == ("stretch", "f")
    assert said["file"] == str(effects / "stretch.py")
    assert ranked["faults"] == []


def test_a_broken_file_is_named_with_its_line_and_the_others_are_ranked(
    store: Store, keep: Keep, effects: Path
) -> None:
    keep()
    write(effects, UNFINISHED, "unfinished")
    late = text_of(FAILS_ON_REAL_SHOTS, name="late")
    write(effects, late, "late")
    asked = request("nylon", measured_files(store, "nylon")) | {"own": str(effects)}
    ranked = ranking_job(asked, silent)
    names = [candidate["effect"] for candidate in ranked["candidates"]]
    assert "stretch" in names
    assert "late" not in names
    faults = {
        fault["effect"]: (Path(fault["path"]).name, fault["line"]) for fault in ranked["faults"]
    }
    assert faults == {
        "unfinished": ("unfinished.py", line_here(UNFINISHED)),
        "late": ("late.py", line_here(late)),
    }


def test_a_fit_that_needs_a_broken_effect_fails_with_the_line(
    store: Store, keep: Keep, effects: Path
) -> None:
    keep()
    late = text_of(FAILS_ON_REAL_SHOTS, name="late")
    write(effects, late, "late")
    asked = request("nylon", measured_files(store, "nylon"), ["late"]) | {"own": str(effects)}
    with pytest.raises(AnalysisInputError) as failed:
        fit_job(asked, silent)
    assert failed.value.part == f"{effects / 'late.py'}, line {line_here(late)}"
    assert "four shots are too few" in failed.value.sentence()


def test_a_folder_is_read_as_it_says_of_itself(effects: Path) -> None:
    write(effects, UNFINISHED, "unfinished")
    read = reading_job({"own": str(effects)}, silent)
    assert read["folder"] == str(effects)
    assert [(one["effect"], Path(one["file"]).name) for one in read["effects"]] == [
        ("stretch", "stretch.py")
    ]
    assert [fault["line"] for fault in read["faults"]] == [line_here(UNFINISHED)]


def test_the_fingerprint_of_a_folder_changes_with_its_files(effects: Path) -> None:
    own = OwnEffects.of(configured(effects))
    before = own.fingerprint()
    assert own.fingerprint() == before
    write(effects, text_of(SAME_AS_PIXEL_ASPECT, name="wider"), "stretch")
    after = own.fingerprint()
    assert after != before
    write(effects, UNFINISHED, "unfinished")
    assert own.fingerprint() != after


def test_names_are_left_to_the_job_only_where_files_may_give_them(
    effects: Path, tmp_path: Path
) -> None:
    OwnEffects.of(configured(effects)).require(["stretch", "drag"])
    empty = tmp_path / "empty"
    empty.mkdir()
    for own in (OwnEffects(None), OwnEffects.of(configured(empty))):
        assert own.asked() == {}
        own.require(["drag"])
        with pytest.raises(NotFoundError) as unknown:
            own.require(["stretch"])
        assert unknown.value.value == "'stretch'"


def test_a_folder_that_is_not_there_is_refused_before_the_daemon_starts(tmp_path: Path) -> None:
    own = OwnEffects.of(configured(tmp_path / "nowhere"))
    with pytest.raises(ConfigurationError) as refused:
        own.check()
    assert refused.value.part == "analysis.effects"
    OwnEffects(None).check()


def test_without_a_folder_nothing_is_of_the_user() -> None:
    known = available(None)
    assert known.own() == []
    assert known.faults == ()
    assert effect_document(known.named("drag")) == effect_document(effect_named("drag"))
