"""What was learned of a pair, written and read again."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.campaign import THESIS_SETUP
from analysis.errors import InputError
from analysis.photometric.learn.appearance import (
    Appearance,
    Sphere,
    read_knowledge,
    write_knowledge,
)
from analysis.photometric.render.camera import camera_of


def drawn(seed: int, markers: int) -> Appearance:
    rng = np.random.default_rng(seed)

    def sphere() -> Sphere:
        return Sphere(
            radius_m=float(rng.uniform(1e-3, 1e-1)),
            markers=rng.normal(size=(markers, 3)),
            alpha=float(rng.uniform(0.05, 0.5)),
            darkness=float(rng.uniform()),
            shading=rng.normal(size=(2, 16)),
            reliefs=rng.normal(size=(2, 9, 9)),
        )

    return Appearance(
        camera=camera_of(THESIS_SETUP.camera, rng.uniform(1e3, 2e3, 2)),
        sigma_px=rng.uniform(0.5, 2.0, 2),
        spheres=(sphere(), sphere()),
        scale_sigma=float(rng.uniform()),
        limb_px=float(rng.uniform()),
        films=int(rng.integers(1, 7)),
        pattern_sigma_rad=float(rng.uniform()),
        slow_px=float(rng.uniform()),
        shared_px=float(rng.uniform()),
        smear_px2=rng.uniform(0.0, 0.5, 2),
        camera_sigma=tuple(map(float, rng.normal(size=2))),
    )


def same(one: Any, other: Any) -> bool:
    if is_dataclass(one):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, tuple):
        return type(one) is type(other) and all(map(same, one, other))
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    return type(one) is type(other) and one == other


@given(seed=st.integers(0, 10**6), markers=st.integers(0, 16))
def test_what_is_read_is_what_was_written_to_the_last_bit_and_type(
    tmp_path_factory: pytest.TempPathFactory, seed: int, markers: int
) -> None:
    known, path = drawn(seed, markers), tmp_path_factory.mktemp("pairs") / "pair.npz"
    with path.open("wb") as file:
        write_knowledge(file, known)
    assert same(known, read_knowledge(path))


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04"])
def test_another_file_is_refused_by_name(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "pair.npz"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"pair\.npz"):
        read_knowledge(path)


def test_another_format_is_refused_with_both_numbers(tmp_path: Path) -> None:
    path = tmp_path / "pair.npz"
    np.savez(path, format=9)
    with pytest.raises(InputError, match="format 9, 6 can be read"):
        read_knowledge(path)
