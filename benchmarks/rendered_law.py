"""A law that no catalogue holds, hidden in a daemon's own world, found from the frames it films.

python -m benchmarks.rendered_law --shots 48 --hides restitution-bump
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.poses import PoseData
from analysis.model.proposals.document import proposals_document
from analysis.model.proposals.propose import propose
from analysis.model.proposals.words import proposal_sentences
from rigctl.config import Configuration, Simulation, load
from rigctl.daemon import open_daemon
from rigctl.firing import measured
from rigctl.local import LocalRig
from rigctl.model.campaigns import campaign_poses
from rigctl.settings import ShotSettings
from simulators.challenge.unnamed import LAWS

FACTORY, CAMPAIGN = "simulators.laboratory:open_laboratory", "hidden-law"
PRESSURES_KPA, OFFSETS_MM = (30.0, 88.0), (1.0, 13.0)
FRAMES_AFTER_MARK = 90
LONGEST_S = 600.0
LASTING = "lasting-contact"
"""An effect that is in this world whatever it hides: its contacts are followed in time."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Fire, measure, propose, and compare with what was hidden."""
    parser = argparse.ArgumentParser(prog="benchmarks.rendered_law", description=__doc__)
    parser.add_argument("--shots", type=int, default=48)
    parser.add_argument("--hides", default="restitution-bump", choices=sorted(LAWS))
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--out", type=Path, default=Path("out/rendered-law"))
    wanted = parser.parse_args(arguments)
    start = time.monotonic()
    data = fired(wanted.out, wanted.shots, wanted.hides, wanted.seed)
    found = propose(data, (), CATALOGUE)
    law = LAWS[wanted.hides]
    print(f"{len(data.shots)} shots measured, {time.monotonic() - start:.0f} s")
    for sentence in proposal_sentences(proposals_document(CAMPAIGN, found)):
        print(sentence)
    said = [(*a.form.group, a.form.shape_name) for a in found.accepted]
    alike = found.accepted[0].alike if found.accepted else ()
    right = bool(said) and (law.slot, law.argument) in [said[0][:2], *alike]
    shaped = right and law.shape in found.accepted[0].shapes
    known = set(found.effects) <= {LASTING}
    print(
        f"hidden {law.slot} against {law.argument}, {law.shape}: {'named' if right else 'MISSED'}, "
        f"shape {'named' if shaped else 'MISSED'}, beside it "
        f"{'nothing that is not there' if known and len(said) == 1 else 'MORE THAN IS THERE'}"
    )


def fired(folder: Path, shots: int, hides: str, seed: int) -> PoseData:
    """Return the poses of shots that a daemon of its own fires and films, a law in its world."""
    shutil.rmtree(folder, ignore_errors=True)
    rng = np.random.default_rng(seed)
    pressures = rng.permutation(np.linspace(*PRESSURES_KPA, shots).round(1))
    offsets = rng.permutation(np.linspace(*OFFSETS_MM, shots).round(2))
    with open_daemon(_configuration(folder, hides, seed)) as daemon:
        rig, names = LocalRig(daemon, "benchmark"), []
        for number, (pressure, offset) in enumerate(zip(pressures, offsets, strict=True)):
            settings = ShotSettings(
                pressure_a_kpa=float(pressure),
                pressure_b_kpa=float(pressure),
                offset_mm=float(offset),
            )
            names.append(rig.fire(rig.arm(settings).token, f"{CAMPAIGN}-{number}", CAMPAIGN))
            daemon.rig.wait(names[-1])
        states = [measured(rig, name, LONGEST_S)["state"] for name in names]
        print(f"{states.count('analysed')} of {shots} shots analysed", flush=True)
        return campaign_poses(daemon.store, CAMPAIGN)[1]


def _configuration(folder: Path, hides: str, seed: int) -> Configuration:
    usual = load(None)
    hiding = {"factory": FACTORY, "seed": seed, "hides": hides}
    camera = {"frames_after_mark": FRAMES_AFTER_MARK, "collect_timeout_s": LONGEST_S}
    return usual.model_copy(
        update={
            "simulation": Simulation.model_validate(hiding),
            "store": usual.store.model_copy(update={"folder": str(folder)}),
            "analysis": usual.analysis.model_copy(update={"method": "thesis"}),
            "camera": usual.camera.model_copy(update=camera),
        }
    )


if __name__ == "__main__":
    main()
