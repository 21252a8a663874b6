"""Laws that no catalogue holds: how often one is proposed where there is none, and the right one.

python -m benchmarks.proposals null --campaigns 400
python -m benchmarks.proposals power --d 6 --campaigns 20
python -m benchmarks.proposals power --d 10 --campaigns 13 --first-seed 900000
python -m benchmarks.proposals products --d 6 --campaigns 20
python -m benchmarks.proposals products --d 6 --own --campaigns 8
python -m benchmarks.proposals drawn --d 6 --campaigns 5
python -m benchmarks.proposals exponent --campaigns 100
python -m benchmarks.proposals central --campaigns 20
python -m benchmarks.proposals launch --campaigns 400
python -m benchmarks.proposals unforeseen --campaigns 3
python -m benchmarks.proposals speed
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.effects.catalogue import CATALOGUE
from analysis.model.data.evidence import stage_of
from analysis.model.data.inside import without_contact_frames
from analysis.model.data.poses import PoseData
from analysis.model.data.stream import whole
from analysis.model.fitting.fit import fit_campaign
from analysis.model.fitting.robust_fit import robust_fit
from analysis.model.predict.contact import encounter_of
from analysis.model.proposals.admissible import admitted
from analysis.model.proposals.launch_search import propose_launch
from analysis.model.proposals.propose import propose
from analysis.model.proposals.proposed import Proposed
from benchmarks.discovery.campaigns import campaign
from benchmarks.discovery.strength import amplitude_at
from benchmarks.discovery.treatments import TREATMENTS
from benchmarks.proposals.drawn import LAWS as DRAWN
from benchmarks.proposals.drawn import drawn_at
from benchmarks.proposals.products import SHARES, WAYS_OFF, product_at
from benchmarks.proposals.trials import Asked, Trial, print_share
from benchmarks.proposals.unforeseen import WORLDS, claimed, fired, is_true
from simulators.challenge.effects import HIDDEN
from simulators.challenge.unnamed import LAWS

Floats = NDArray[np.float64]

OUT = Path("out")
SHOTS = 120
FIRST_SEED = 700_000
PRODUCT = "*"
SMALL_SET = 3
BESIDE = {"image-scale": 0.005, "mass-mismatch": 0.01, "torsional-friction": 0.0008}
"""Effects of the catalogue beside which nothing may be proposed, at full strength."""
SAYS = {"friction-speed": ("mu", "speed_s"), "restitution-drift": ("e", "order")}


def trial(
    amplitudes: dict[str, float], seed: int, *, treatment: str = "as stated", floor: bool = False
) -> tuple[Trial, Proposed]:
    """Make a campaign, and have laws proposed for it."""
    data = TREATMENTS[treatment](
        campaign(amplitudes, seed, SHOTS), np.random.default_rng([seed, 7])
    )
    one, found = _asked(data, " ".join(amplitudes), seed)
    if floor:
        quiet = without_contact_frames(campaign({}, seed, SHOTS))
        one = replace(one, floor=stage_of(quiet, fit_campaign(quiet)).error.value)
    return replace(one, treatment=treatment), found


def _asked(data: PoseData, hidden: str, seed: int) -> tuple[Trial, Proposed]:
    """Have laws proposed for a campaign, and note what was said."""
    start = time.process_time()
    found = propose(data, (), CATALOGUE)
    seconds = time.process_time() - start
    return Trial(
        hidden=hidden,
        seed=seed,
        treatment="as stated",
        proposals=tuple(
            (*form.group, form.shape_name)
            for form in (*(a.form for a in found.accepted), *(a.form for a in found.launch))
        ),
        alike=found.accepted[0].alike if found.accepted else (),
        effects=found.effects,
        before=found.path[0].error.value,
        after=found.path[-1].error.value,
        floor=float("nan"),
        seconds=seconds,
    ), found


def null(asked: Asked) -> list[Trial]:
    """Count proposals where nothing is missing, or what is missing is in the catalogue."""
    tried = []
    kinds: list[tuple[str, dict[str, float]]] = [(name, {}) for name in list(TREATMENTS)[:3]]
    kinds += [("as stated", {name: size}) for name, size in BESIDE.items()]
    for treatment, hidden in kinds:
        if asked.of not in f"{' '.join(hidden) or 'nothing'}, {treatment}":
            continue
        count = asked.campaigns if not hidden else max(asked.campaigns // len(BESIDE), 1)
        own = [trial(hidden, asked.first_seed + k, treatment=treatment)[0] for k in range(count)]
        for one in own:
            if one.proposals:
                print(f"  {one}")
        said = f"{' '.join(hidden) or 'nothing'} hidden, {treatment}: proposals"
        print_share(said, 0.05, [bool(one.proposals) for one in own], at_least=False)
        tried += own
    return tried


def power(asked: Asked) -> list[Trial]:
    """Hide each law at one strength: the right slot and argument first, or in a small set."""
    tried, hits = list[Trial](), list[bool]()
    chosen = {name: law for name, law in LAWS.items() if asked.of in name}
    for name, law in chosen.items():
        own = []
        for k in range(asked.campaigns):
            seed = asked.first_seed + 10_000 + k
            amplitude = amplitude_at(name, asked.d, seed, SHOTS)
            own.append(trial({name: amplitude}, seed, floor=True)[0])
        right = (law.slot, law.argument)
        share = 0.98 if asked.d >= 10 else 0.75 if PRODUCT in law.argument else 0.9
        for one in own:
            if not _named(one, right):
                print(f"  {one}")
        first = [
            one.proposals[:1] == ((*right, one.proposals[0][2]),) if one.proposals else False
            for one in own
        ]
        print_share(f"d {asked.d:g} {name}: first", 0.0, first)
        print_share(
            f"d {asked.d:g} {name}: first, or in a set of at most three",
            share,
            [_named(one, right) for one in own],
        )
        excess = [one.after / one.floor - 1 for one in own if one.proposals]
        print(
            f"    error after over the floor: {np.mean(excess):.4f}, largest {max(excess):.4f}"
            if excess
            else "    nothing proposed"
        )
        tried += own
        hits += [_named(one, right) for one in own]
    if len(chosen) > 1:
        print_share(
            f"d {asked.d:g}, all laws: first, or in a set of at most three",
            0.98 if asked.d >= 10 else 0.9,
            hits,
        )
    return tried


def _named(one: Trial, right: tuple[str, str]) -> bool:
    """Whether the first proposal is right, or holds what is right in a set of at most three.

    An effect of the catalogue that says the same of the same slot and argument is right too: it
    is preferred to a form that does no better.
    """
    if any(SAYS.get(name) == right for name in one.effects):
        return True
    if not one.proposals:
        return False
    found = [one.proposals[0][:2], *one.alike]
    return found[0] == right or (right in found and len(found) <= SMALL_SET)


def products(asked: Asked) -> list[Trial]:
    """Hide products at one strength, their zeros on and off the shots."""
    tried = list[Trial]()
    rows = []
    for off in WAYS_OFF:
        for k in range(asked.campaigns):
            seed = asked.first_seed + 70_000 + k
            made = product_at(asked.d, off, seed, SHOTS, own=asked.own)
            group = made.pair.group
            one, _ = _asked(made.data, f"{' on '.join(group)}, {off} off", seed)
            named, first = _named(one, group), one.proposals[:1]
            right = bool(first) and first[0][:2] == group
            rows.append((made.share, right, named, made.likely))
            tried.append(one)
        own = rows[-asked.campaigns :]
        shares = [row[0] for row in own]
        print(
            f"zero {off} deviations off: arguments alone do {min(shares):.2f} to {max(shares):.2f}"
        )
        print_share(f"d {asked.d:g} zero {off} deviations off: first", 0.0, [row[1] for row in own])
        print_share(
            f"d {asked.d:g} zero {off} deviations off: in the set", 0.75, [r[2] for r in own]
        )
        print(f"    likelihood alone has it among three: {np.mean([r[3] for r in own]):.2f}")
    for low, high in pairwise(SHARES):
        own = [row for row in rows if low <= row[0] < high]
        text = f"d {asked.d:g} arguments alone do {low:g} to {high:g}"
        print_share(f"{text}: first", 0.0, [row[1] for row in own])
        print_share(f"{text}: in the set", 0.75, [row[2] for row in own])
    return tried


def drawn(asked: Asked) -> list[Trial]:
    """Hide laws of other kinds than tests do, in hard spheres and in contacts that last."""
    tried, share = list[Trial](), 0.98 if asked.d >= 10 else 0.9
    for world, lasting in (("hard", False), ("lasting", True)):
        hits, excess = list[bool](), list[float]()
        for name, law in DRAWN.items():
            if asked.of not in f"{world}, {name}":
                continue
            for k in range(asked.campaigns):
                seed = asked.first_seed + 80_000 + k
                data = drawn_at(law, asked.d, seed, SHOTS, lasting=lasting)
                one, found = _asked(data, f"{world}, {name}", seed)
                hits.append(_named(one, (law.slot, law.argument)))
                if not hits[-1]:
                    print(f"  {one}", flush=True)
                elif found.accepted and not lasting:
                    quiet = without_contact_frames(campaign({}, seed, SHOTS))
                    floor = stage_of(quiet, fit_campaign(quiet)).error.value
                    excess.append(one.after / floor - 1)
                tried.append(one)
        if hits:
            print_share(f"d {asked.d:g}, {world}: first, or in a set of at most three", share, hits)
        if excess:
            print(f"    error after over the floor: {np.mean(excess):.4f}, most {max(excess):.4f}")
    return tried


def exponent(asked: Asked) -> list[Trial]:
    """Hold the exponent of a central force in flight against its standard error."""
    tried, named, hits = [], [], []
    for k in range(asked.campaigns):
        seed = asked.first_seed + 20_000 + k
        amplitude = amplitude_at("attraction-power", asked.d, seed, SHOTS)
        one, found = trial({"attraction-power": amplitude}, seed)
        tried.append(one)
        first = next((a for a in found.accepted if a.form.slot == "flight"), None)
        named.append(first is not None and first.form.shape_name == "power")
        if first is None or not named[-1]:
            print(f"  seed {seed} d {asked.d:g}: {one.proposals or 'nothing'}", flush=True)
            continue
        value = first.freed.parameters()[f"{first.name}.p"]
        hits.append(abs(value.value - 4.0) < 2 * value.sigma)
        print(f"  seed {seed} d {asked.d:g}: p = {value.concise()}", flush=True)
    print_share(f"d {asked.d:g}: proposed as a power of the distance", 0.9, named)
    print_share(f"d {asked.d:g}: exponent of 1/d^4 within two standard errors", 0.95, hits)
    return tried


def central(asked: Asked) -> list[Trial]:
    """Have a force as 1/d^4 proposed: one in flight, and nothing of the contact beside it."""
    size = HIDDEN["attraction-power"].amplitude
    tried = [
        trial({"attraction-power": size}, asked.first_seed + 30_000 + k, floor=True)[0]
        for k in range(asked.campaigns)
    ]
    right = [one.proposals[:1] == (("flight", "distance", "power"),) for one in tried]
    print_share("full strength: proposed as a power of the distance", 0.95, right)
    alone = [len(one.proposals) == 1 and not one.effects for one in tried]
    print_share("full strength: nothing beside it", 0.95, alone)
    return tried


def launch(asked: Asked) -> list[Trial]:
    """Ask the launches alone: where they follow their settings, and where they follow the room."""
    for name, per_kelvin, share in (("nothing", 0.0, 0.01), ("temperature", 0.004, 0.9)):
        if asked.of not in name:
            continue
        hits = []
        for k in range(asked.campaigns if per_kelvin == 0 else max(asked.campaigns // 10, 1)):
            data = campaign({}, asked.first_seed + 50_000 + k, SHOTS)
            known = _warm_pushers(data.covariates, per_kelvin)
            base = robust_fit(replace(data, covariates=known), ())
            told = whole(base.data)
            met = encounter_of(told, base.fit.states, base.fit.theory)
            arguments = admitted(met, scalars=False, one_frame=True).arguments
            found = propose_launch(told, base.fit, met, arguments)
            said = [(one.form.quantity, one.form.argument) for one in found]
            hits.append(bool(said) if not per_kelvin else said[:1] == [("speed", "temperature_c")])
            if hits[-1] != bool(per_kelvin):
                print(f"  seed {asked.first_seed + 50_000 + k}: {said}")
        print_share(
            f"launch, {name}: {'named' if per_kelvin else 'proposals'}",
            share,
            hits,
            at_least=per_kelvin > 0,
        )
    return []


def _warm_pushers(known: Mapping[str, Floats], per_kelvin: float) -> dict[str, Floats]:
    """Return covariates whose pressures are those that would do without any gain with warmth."""
    gain = 1.0 + per_kelvin * (known["temperature_c"] - 23.0)
    return {k: v / gain**2 if k.startswith("pressure") else v for k, v in known.items()}


def unforeseen(asked: Asked) -> list[Trial]:
    """Say what is claimed of worlds that were not built for this, and whether it is true."""
    for name, world in WORLDS.items():
        if asked.of not in name:
            continue
        hits = []
        for k in range(asked.campaigns):
            seed = asked.first_seed + 60_000 + k
            found, named, meant = claimed(fired(world, seed, SHOTS))
            hits.append(is_true(world, found, meant))
            said = ", ".join(
                f"{slot} on {argument}"
                + (f" (or {len(groups) - 1} alike)" if len(groups) > 1 else "")
                for (slot, argument), groups in zip(named, meant, strict=True)
            )
            beside = f" beside {', '.join(found.effects)}" if found.effects else ""
            error = found.path[-1].error.value
            print(f"  {seed}: {said or 'nothing'}{beside}; error {error:.4f}", flush=True)
        print_share(f"{name}: {world.told}", 0.0, hits)
    return []


def speed(asked: Asked) -> list[Trial]:
    """Take the processor time of 120 and of 1000 shots, functions compiled.

    Of 120 shots also in worlds whose contacts last.
    """
    global SHOTS
    trial({}, 1)
    for SHOTS, limit in ((120, 2.0), (1000, 10.0)):
        for hidden in ({}, {"restitution-bump": 0.02}):
            one, _ = trial(hidden, 2)
            _took(f"{SHOTS} shots, {' '.join(hidden) or 'nothing'} hidden", one.seconds, limit)
    for name in (name for name in WORLDS if name.startswith("lasting")):
        data = fired(WORLDS[name], asked.first_seed + 60_000, 120)
        if name == "lasting-temperature":
            claimed(data)
        start = time.process_time()
        _, named, _ = claimed(data)
        said = ", ".join(" on ".join(group) for group in named) or "nothing"
        _took(f"120 shots, {name}: {said}", time.process_time() - start, 2.0)
    return []


def _took(text: str, seconds: float, limit: float) -> None:
    kept = "kept" if seconds <= limit else "MISSED"
    print(f"{text}: {seconds:.2f} s <= {limit:g} s {kept}", flush=True)


SECTIONS = {
    "null": null,
    "power": power,
    "products": products,
    "drawn": drawn,
    "exponent": exponent,
    "central": central,
    "launch": launch,
    "unforeseen": unforeseen,
    "speed": speed,
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one section."""
    parser = argparse.ArgumentParser(prog="benchmarks.proposals", description=__doc__)
    parser.add_argument("section", choices=SECTIONS)
    parser.add_argument("--campaigns", type=int, default=20, help="of each kind")
    parser.add_argument("--d", type=float, default=6.0, help="strength of what is hidden")
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED, help="other campaigns")
    parser.add_argument("--of", default="", help="only kinds whose name holds this")
    parser.add_argument(
        "--own", action="store_true", help="products: d of what their arguments alone do not do"
    )
    wanted = parser.parse_args(arguments)
    tried = SECTIONS[wanted.section](
        Asked(wanted.campaigns, wanted.d, wanted.of, wanted.first_seed, wanted.own)
    )
    OUT.mkdir(exist_ok=True)
    path = OUT / f"proposals-{wanted.section}.json"
    path.write_text(json.dumps([asdict(one) for one in tried], indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
