"""The sweep file: what it says, and what is wrong in it."""

from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rigctl.errors import ConfigurationError, StoreError
from rigctl.plain_text import PLAIN
from rigctl.settings import ShotSettings
from rigctl.sweeps.form import Grid, Range, RepeatedShot, Sweep, read_sweep, sweep_text, write_sweep

FILE = """\
campaign = "nylon-2"
shuffle = false

[grid]
pressure_a_kpa = { first = 20, last = 80, count = 3 }
offset_mm = [0, 6]

[[shots]]
pressure_a_kpa = 95
pressure_b_kpa = 90
offset_mm = 2.8
repeat = 2
"""

PRESSURE = st.floats(0, 1000)
OFFSET = st.floats(-100, 100)
LISTED = st.lists(OFFSET, min_size=1, max_size=4, unique=True)
RANGES = st.builds(
    Range,
    first=st.floats(1, 400),
    last=st.floats(500, 1000),
    count=st.integers(2, 9),
    spacing=st.sampled_from(["linear", "logarithmic", "root"]),
)
SHOTS = st.builds(
    RepeatedShot,
    pressure_a_kpa=PRESSURE,
    pressure_b_kpa=PRESSURE,
    offset_mm=OFFSET,
    repeat=st.integers(1, 50),
)
SWEEPS = st.builds(
    Sweep,
    campaign=st.none() | st.from_regex(r"\A[A-Za-z0-9][A-Za-z0-9._-]{0,63}\Z"),
    note=st.from_regex(PLAIN, fullmatch=True).filter(lambda note: len(note) <= 50),
    repeat=st.integers(1, 5),
    shuffle=st.booleans(),
    seed=st.integers(0, 2**63 - 1),
    settle_s=st.floats(0, 3600),
    grid=st.none() | st.builds(Grid, pressure_a_kpa=RANGES, offset_mm=LISTED),
    shots=st.lists(SHOTS, min_size=1, max_size=4),
)


def refusal(folder: Path, old: str, new: str) -> str:
    assert old in FILE
    path = folder / "sweep.toml"
    path.write_text(FILE.replace(old, new), encoding="utf-8")
    with pytest.raises(ConfigurationError) as caught:
        read_sweep(path)
    return caught.value.sentence()


def test_the_order_as_written_is_the_grid_and_then_the_list(tmp_path: Path) -> None:
    path = tmp_path / "sweep.toml"
    path.write_text(FILE, encoding="utf-8")
    fired = [
        (s.pressure_a_kpa, s.pressure_b_kpa, s.offset_mm, s.delay_us)
        for s in read_sweep(path).steps()
    ]
    grid = [(p, p, offset, 0.0) for p in (20.0, 50.0, 80.0) for offset in (0.0, 6.0)]
    assert fired == [*grid, (95.0, 90.0, 2.8, 0.0), (95.0, 90.0, 2.8, 0.0)]


@settings(max_examples=40, deadline=None)
@given(SWEEPS)
def test_a_sweep_reads_back_as_it_was_written(
    tmp_path_factory: pytest.TempPathFactory, sweep: Sweep
) -> None:
    path = tmp_path_factory.getbasetemp() / "written.toml"
    write_sweep(path, sweep)
    assert read_sweep(path) == sweep


@settings(max_examples=40, deadline=None)
@given(SWEEPS)
def test_shuffling_changes_the_order_and_nothing_else(sweep: Sweep) -> None:
    written = sweep.model_copy(update={"shuffle": False}).steps()
    drawn = sweep.model_copy(update={"shuffle": True})
    assert Counter(drawn.steps()) == Counter(written)
    assert drawn.steps() == drawn.steps()
    assert len(written) == sweep.count()


def test_another_seed_draws_another_order() -> None:
    shots = [RepeatedShot(pressure_a_kpa=p, pressure_b_kpa=p, offset_mm=0.0) for p in range(10, 40)]
    first, second = (Sweep(shots=shots, seed=seed).steps() for seed in (1, 2))
    assert first != second


@pytest.mark.parametrize(
    ("spacing", "middle"), [("linear", 62.5), ("logarithmic", 50.0), ("root", 56.25)]
)
def test_a_range_spaces_what_it_names(spacing: str, middle: float) -> None:
    spaced = Range.model_validate({"first": 25.0, "last": 100.0, "count": 3, "spacing": spacing})
    assert spaced.values() == pytest.approx([25.0, middle, 100.0])


def test_a_range_may_fall() -> None:
    assert Range(first=30.0, last=10.0, count=3).values() == [30.0, 20.0, 10.0]


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("count = 3", "count = 1", ["grid.pressure_a_kpa.count", "found 1", "at least 2"]),
        (", count = 3", "", ["grid.pressure_a_kpa.count", "is missing"]),
        ("[0, 6]", "[]", ["grid.offset_mm", "at least 1"]),
        ("[0, 6]", '[0, "6"]', ["grid.offset_mm[1]", "'6'"]),
        ("[0, 6]", "[0, 600]", ["grid", "offset_mm", "600", "100"]),
        ("[0, 6]", "true", ["grid.offset_mm", "True"]),
        ("= 95", "= 4000", ["shots[0].pressure_a_kpa", "4000", "at most 1000"]),
        ("repeat = 2", "repeat = 0", ["shots[0].repeat", "found 0", "at least 1"]),
        ("repeat = 2", "repeats = 2", ["unknown key shots[0].repeats", "did you mean repeat?"]),
        ("nylon-2", "a b", ["campaign", "'a b'"]),
        ("shuffle = false", "seed = -1", ["seed", "-1", "at least 0"]),
        ("count = 3", 'count = 3, spacing = "cubic"', ["spacing", "'cubic'", "'root'"]),
        ("first = 20", 'spacing = "logarithmic", first = 0', ["logarithmic", "above 0"]),
        ("campaign", "campaign = = ", ["not TOML"]),
    ],
)
def test_what_is_wrong_is_named_by_file_field_value_and_limit(
    tmp_path: Path, old: str, new: str, parts: list[str]
) -> None:
    sentence = refusal(tmp_path, old, new)
    assert "sweep.toml" in sentence
    for part in parts:
        assert part in sentence


def test_a_sweep_without_a_shot_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "empty.toml"
    path.write_text('campaign = "x"\n', encoding="utf-8")
    with pytest.raises(ConfigurationError, match="1 to 10000 shots, this one 0"):
        read_sweep(path)


def test_a_sweep_beyond_all_patience_is_refused() -> None:
    shot = {"pressure_a_kpa": 1.0, "pressure_b_kpa": 1.0, "offset_mm": 0.0, "repeat": 1000}
    with pytest.raises(ValueError, match="this one 11000"):
        Sweep.model_validate({"shots": [shot] * 11})


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"nowhere\.toml.*no such file"):
        read_sweep(tmp_path / "nowhere.toml")


def test_a_folder_that_is_not_there_cannot_be_written_to(tmp_path: Path) -> None:
    shot = RepeatedShot(pressure_a_kpa=1.0, pressure_b_kpa=1.0, offset_mm=0.0)
    with pytest.raises(StoreError, match="cannot be written"):
        write_sweep(tmp_path / "nowhere" / "sweep.toml", Sweep(shots=[shot]))


def test_what_is_at_its_default_is_not_written() -> None:
    shot = RepeatedShot(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0)
    assert sweep_text(Sweep(shots=[shot])) == (
        "[[shots]]\npressure_a_kpa = 40.0\npressure_b_kpa = 40.0\noffset_mm = 6.0\n"
    )
    assert ShotSettings(pressure_a_kpa=40.0, pressure_b_kpa=40.0, offset_mm=6.0) == shot.settings()
