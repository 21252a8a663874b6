"""Whether jumps at contact scatter as stated: python -m benchmarks.jumps FOLDER [FOLDER ...].

Each folder is an exported campaign with nothing missing but the named effects, such as a sweep that
the simulated rig fired. Fits them, sets each velocity and spin after contact free, one kind after
the other, and prints the chi-squared that this takes off over its degrees of freedom, by campaign
and of all. 1 is right, the standard error of all is the root of 2 over the degrees of freedom.
Errors that all shots share are fitted beside, as the cells of lack of fit have them.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from pathlib import Path

import numpy as np

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.gather import gather_poses
from analysis.model.data.poses import PoseData
from analysis.model.fitting.fit import Fit
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.fitting.slow_errors.field import field_errors
from analysis.model.rank.projector import ColumnSums, projector
from analysis.model.structure.channels import contact_columns


def scatter(data: PoseData, fit: Fit) -> dict[str, tuple[float, int]]:
    """Return chi-squared and degrees of freedom of the jumps of each channel, shot by shot."""
    sums = projector(data, fit, field_errors(data))
    columns = contact_columns(data, fit.states, fit.theory)
    found = {}
    for name, column in columns.items():
        by_shot = sums.project(column)
        own = ColumnSums(
            np.diag(by_shot.own[:, 0, 0]),
            by_shot.against[:, 0],
            by_shot.gradient[:, 0],
            by_shot.raw[:, 0],
        )
        solved = own.solved(sums.covariance, sums.left)
        found[name] = solved.chi2, solved.freedom
    return found


def main() -> None:
    """Fit, set free and print."""
    parser = argparse.ArgumentParser(prog="benchmarks.jumps", description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--with", dest="effects", nargs="*", default=["lasting-contact"])
    chosen = parser.parse_args()
    effects = [effect for effect in CATALOGUE if effect.name in chosen.effects]
    every: dict[str, list[tuple[float, int]]] = defaultdict(list)
    for folder in chosen.folders:
        found = robust_fit(gather_poses(folder)[1], effects)
        data = found.data
        assert isinstance(data, PoseData), folder
        sizes = data.slow.sizes
        print(f"{folder}: {data.count} shots, chi2/dof {found.fit.chi2_per_dof:.3f}", end="")
        print(f", slow errors {1e6 * sizes[0][0]:.2f} um, Z {1e6 * sizes[0][2]:.2f} um", end="")
        print(f", turns {1e3 * sizes[1][0]:.3f} mrad")
        for name, own in scatter(data, found.fit).items():
            every[name].append(own)
    for name, parts in every.items():
        chi2, freedom = np.array(parts).sum(axis=0)
        each = " ".join(f"{own / free:5.2f}" for own, free in parts)
        print(f"  {name:20s}{chi2 / freedom:7.3f} +- {np.sqrt(2 / freedom):.3f}   {each}")


if __name__ == "__main__":
    main()
