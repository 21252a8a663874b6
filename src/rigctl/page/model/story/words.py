"""Plain words for what is measured and for what an error goes with."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from analysis.model.structure.findings import ALWAYS
from analysis.model.verdict.standing import SURE, Standing, Word, stands_without_two
from analysis.schema.verdict import Nuisance
from rigctl.documents import Json
from rigctl.page.model.story.cards import in_plain

ALONG = {"n": "along the centres", "t": "along the sliding", "b": "sideways"}
TURNS = {"n": "twist", "t": "tumbling", "b": "rolling"}
"""Turning about the line of centres, about the sliding, and across both: as a wheel rolls."""
KINDS = {
    "relative velocity": {"n": "speed along the line of centres", "t": "sliding speed"}
    | {"b": "sideways speed"},
    "common velocity": {axis: f"mean speed of both {way}" for axis, way in ALONG.items()},
    "relative spin": {axis: f"difference of {turn}" for axis, turn in TURNS.items()},
    "common spin": {axis: f"mean {turn}" for axis, turn in TURNS.items()},
    "relative position": {axis: f"gap between spheres {way}" for axis, way in ALONG.items()},
    "common position": {axis: f"path of both {way}" for axis, way in ALONG.items()},
    "relative orientation": {axis: f"difference of {turn} angles" for axis, turn in TURNS.items()},
    "common orientation": {axis: f"mean {turn} angle" for axis, turn in TURNS.items()},
}
CHANNELS = {
    **{f"{kind} {axis}": word for kind, axes in KINDS.items() for axis, word in axes.items()},
    "normal velocity": "speed along the line of centres",
    "tangential velocity": "sliding speed",
    "velocity out of plane": "sideways speed",
    "common velocity": "mean speed of both",
    "common spin": "mean spin of both",
    "position a": "place of sphere a",
    "position b": "place of sphere b",
    "orientation a": "turn of sphere a",
    "orientation b": "turn of sphere b",
    "relative position": "gap between spheres in flight",
    "common position": "path of both in flight",
    "relative orientation": "difference of turns in flight",
    "common orientation": "turn of both in flight",
    "relative spin": "difference of spins",
    "speed": "speed from the tube",
    "slope X": "rise of the track",
    "slope Z": "turn of the track to the side",
    "track offset X": "offset between the tracks, height",
    "track offset Z": "offset between the tracks, depth",
    "track height X": "place of both tracks, height",
    "track height Z": "place of both tracks, depth",
    "lag": "delay between the launches",
    "image X": "measured height",
    "image Y": "measured left–right",
    "image Z": "measured depth",
}
ON_PLATE = {
    "relative velocity n": "speed towards the plate",
    "relative velocity b": "sideways speed",
    **{f"relative spin {axis}": turn for axis, turn in TURNS.items()},
    "relative position n": "height over the plate",
    "relative position t": "place along the plate",
    "relative position b": "place to the side",
    **{f"relative orientation {axis}": f"{turn} angle" for axis, turn in TURNS.items()},
    "normal velocity": "speed towards the plate",
    "position a": "place of the sphere",
    "orientation a": "turn of the sphere",
    "relative position": "path in flight",
    "relative orientation": "turn in flight",
    "relative spin": "spin",
}
"""The same of one sphere that meets a plate, where two would be spoken of."""
COVARIATES = {
    "ln v_n": "approach speed",
    "ln v_s/v_n": "sliding ÷ approach",
    "spin along v_t x n": "rolling spin before",
    "spin about n": "twist before",
    "contact X": "height of the contact",
    "contact Y": "left–right of the contact",
    "contact Z": "depth of the contact",
    "time": "time from contact",
    "field X": "place in the picture (height)",
    "field Y": "place in the picture (left–right)",
    "field Z": "place in the picture (depth)",
    "order": "order of firing",
    "pressure_a_kpa": "pressure a (sets the speed)",
    "pressure_b_kpa": "pressure b (sets the speed)",
    "offset_mm": "offset (sets the angle)",
    "delay_us": "delay of b",
    "temperature_c": "temperature",
}


_LONGEST_FIRST = sorted([*COVARIATES, ALWAYS], key=len, reverse=True)
CELL = re.compile(
    rf"((?:{'|'.join(KINDS)}) [ntb]|image [XYZ]) against "
    rf"({'|'.join(map(re.escape, _LONGEST_FIRST))}|\w+)"
)
"""A cell as verdicts name it: what is measured, and what its error goes with."""


def cells_in_plain(text: str, *, on_plate: bool = False) -> str:
    """Return a text with the cells that it names, `common spin n against order`, in plain words."""
    return CELL.sub(
        lambda found: in_words({"channel": found[1], "covariate": found[2], "on_plate": on_plate}),
        text,
    )


def sized(row: Json) -> str:
    """Return the size of an error with its unit, to three figures."""
    value, unit = row["size"], str(row["unit"]).replace("us", "µs")
    return f"{value:.0f} {unit}" if value >= 1000 else f"{value:.3g} {unit}"


def channel(cell: Json) -> str:
    """Return what is measured in plain words, from a cell or a row of agreement."""
    name = str(cell["channel"] if "channel" in cell else cell["quantity"])
    plain = name.removesuffix(" against place").removesuffix(" against time")
    if cell.get("on_plate") and plain in ON_PLATE:
        return ON_PLATE[plain]
    return CHANNELS.get(plain, plain.replace("_", " "))


TWICE = ("position ", "orientation ")
"""Of the poses, which are measured before contact and after it: two rows with one name each."""


def quantity(row: Json) -> str:
    """Return what a row of agreement is about, in plain words; of poses also when."""
    name, stage = str(row["quantity"]), str(row.get("stage", ""))
    is_pose = name.startswith(TWICE) and stage.endswith("contact")
    return f"{channel(row)}, {stage}" if is_pose else channel(row)


def covariate(name: str) -> str:
    """Return what an error goes with in plain words; unknown columns keep their own."""
    return COVARIATES.get(name, name.replace("_", " "))


HEADINGS = {
    ALWAYS: "always",
    "contact X": "height",
    "contact Y": "left–right",
    "contact Z": "depth",
    "field X": "height",
    "field Y": "left–right",
    "field Z": "depth",
    "pressure_a_kpa": "pressure a",
    "pressure_b_kpa": "pressure b",
    "offset_mm": "offset",
    "spin along v_t x n": "rolling spin",
    "spin about n": "twist",
}
"""Shorter words for a column that stands below the name of its group."""


def heading(name: str) -> str:
    """Return what an error goes with as the head of a column."""
    return HEADINGS.get(name, covariate(name))


def goes_with(finding: Json) -> str:
    """Return what the error of a finding goes with, in some words."""
    if finding["covariate"] == ALWAYS:
        return "in all shots alike"
    return f"with {covariate(finding['covariate'])}"


def fails_where(findings: Sequence[Json]) -> str:
    """Return what the error goes with, in some words, where something is said to be missing."""
    first = findings[0]
    return goes_with(first) if first["p_familywise"] < SURE else "in all shots together"


def in_words(finding: Json) -> str:
    """Return the name of a finding, or of a row of agreement, in plain words."""
    if "quantity" in finding:
        return f"the {quantity(finding)}"
    return f"the {channel(finding)}, {goes_with(finding)}"


def failing(found: Json) -> list[Json]:
    """Return all rows of agreement: those that fail first, the worst in units of the noise.

    What no view shows, as the depth of a film, is predicted by definition, and no row.
    """
    rows = [
        {**row, "stage": stage.get("stage", "")}
        for stage in found["stages"]
        for row in stage["quantities"]
        if row.get("degrees_of_freedom", 1.0) > 0.0
    ]
    return sorted(rows, key=lambda row: (row["p_familywise"] >= SURE, -row["error"]))


HIGH = 1.2
"""Multiple of the noise from which a quantity that agrees is named: its bar stands out."""


def compared(found: Json, standing: Standing | None = None) -> str:
    """Say how wrong the model is at its worst, without contradicting how it stands over all."""
    wrong = [row for row in failing(found) if row["p_familywise"] < SURE]
    if found.get("estimated"):
        worst = failing(found)[0]
        return (
            f"The model predicts the {quantity(worst)} to {sized(worst)}. "
            f"No errors are stated, so they are taken from the scatter; whether "
            "that is noise, step 2 shows."
        )
    if not wrong:
        highest = failing(found)[0]
        said = (
            "Everything that was measured agrees with the model, as far as the noise lets one see."
        )
        if highest["error"] <= HIGH:
            return said
        return (
            f"{said} Highest stands the {quantity(highest)}, at {highest['error']:.3g} times its "
            "noise: chance alone may do that."
        )
    worst = wrong[0]
    if standing is not None and standing.word is Word.FLOOR:
        rest = "alone stands" if len(wrong) == 1 else f"and {len(wrong) - 1} more stand"
        return (
            "Over everything together the model errs no more than the noise. Of "
            f"{len(failing(found))} quantities the {quantity(worst)} {rest} out, by "
            f"{sized(worst)}: {worst['error']:.3g} times its noise."
        )
    if standing is not None and standing.word in {Word.FEW, Word.UNSURE}:
        return (
            f"The model gets the {quantity(worst)} wrong by {sized(worst)}: {worst['error']:.3g} "
            "times the noise. That may be an error of single shots: so few do not tell."
        )
    rest = (
        "so this is no noise"
        if stands_without_two(wrong)
        else "but hardly without its two worst shots, which may err by themselves"
    )
    return (
        f"The model gets the {quantity(worst)} wrong by {sized(worst)}: "
        f"{worst['error']:.3g} times the noise, {rest}."
    )


FAR = re.compile(r"chi-squared per degree of freedom (\S+) times that of the median shot")


def rejected_in_plain(reason: str) -> str:
    """Return why a fit left out a shot without chi-squared: errors go with its root."""

    def plain(found: re.Match[str]) -> str:
        times = math.sqrt(float(found[1]))
        return f"over its whole film the model errs {times:.2g} times as much as in a usual shot"

    return FAR.sub(plain, reason)


STATED = {
    "outline-offset": "where the outlines lie",
    "orientation-offset": "how the spheres are turned",
}
"""Of stated numbers that are no effect of the catalogue."""


def alarms_in_plain(alarms: Sequence[Nuisance]) -> list[str]:
    """Return words on the stated numbers that the fit moves away; the tables give their sizes."""
    if not alarms:
        return []
    effects = dict.fromkeys(one.name.partition(".")[0] for one in alarms)
    named = [STATED.get(name, in_plain(name)) for name in effects]
    furthest = max(abs(one.pull) for one in alarms)
    return [
        f"The model fits only with other values than were stated, up to {furthest:.0f} times "
        f"their stated errors off: {', '.join(named)}. They make up for what the model lacks, or "
        "were stated wrongly. Add what is missing, then look again."
    ]


ENDS = {
    "ln v_n": ("in slow hits", "in fast ones"),
    "ln v_s/v_n": ("in hits that are nearly head on", "in grazing ones"),
    "order": ("in the first shots", "in the last"),
    "time": ("in the first pictures", "in the last"),
}
"""Which shots or pictures lie at the two ends of a covariate."""
MISSING = {
    Word.UNEXPLAINED: "nothing that is known",
    Word.FEW: "too few shots",
    Word.UNSURE: "nothing is sure",
    Word.ALIKE: "one of two",
    Word.FLOOR: "nothing",
}


def _signed(value: float) -> str:
    return f"{value:+.3g}".replace("-", "−")


def missing_words(standing: Standing | None) -> str:
    """Say in some words what is missing; the names of effects are those of the catalogue."""
    if standing is None:
        return "not known yet"
    return standing.missing[0] if standing.missing else MISSING[standing.word]


def where(cell: Json, points: Json, standing: Standing | None) -> str:
    """Say how the error of a cell goes with its covariate, from the curve that is drawn.

    Where the model is not said to miss anything, no cell is said to show that it does.
    """
    if cell["p_familywise"] >= SURE:
        if standing is not None and standing.is_open:
            return (
                "No cell by itself shows what is missing: only all shots together do. Here "
                f"the {channel(cell)} looks like noise."
            )
        return "No error goes with anything that was recorded: what is left looks like noise."
    if standing is not None and not standing.is_open:
        return (
            f"What is left shows most {goes_with(cell)}, but too little, or in too few shots, to "
            "say that something is missing."
        )
    mean, unit = np.asarray(points["trend"]["mean"]), points["unit"]
    asked = f" {MAKES_UP}" if asks(points) else ""
    if cell["covariate"] == ALWAYS:
        return (
            f"The {channel(cell)} is wrong in all shots alike, by "
            f"{_signed(mean.mean())} {unit} on average.{asked}"
        )
    places = {"first": 0, "middle": len(mean) // 2, "last": len(mean) - 1}
    least, middle, most = (_beside(mean[place], unit) for place in places.values())
    first, last = ENDS.get(cell["covariate"], ("where it is least", "where it is most"))
    return (
        f"The {channel(cell)} goes wrong with the {covariate(cell['covariate'])}. "
        f"Measured is {least} {first}, {middle} in the middle, {most} {last}.{asked}"
    )


MAKES_UP = (
    "In the film of step 1 less of it is seen: place, speed and moment of contact are fitted to "
    "each shot, and make up for most of it."
)


def asks(points: Json) -> bool:
    """Return whether points are of frames, whose curve stands for what the shots' numbers hide."""
    return any(frame >= 0 for frame in points["frames"])


def _beside(value: float, unit: str) -> str:
    """Return how far what was measured lies above or below the model."""
    side = "above" if value >= 0 else "below"
    return f"{abs(value):.3g} {unit} {side} the model"


def looked_at(found: Json, seen: int, known: int) -> str:
    """Say how many effects of those that are known would show in these shots, and why not all."""
    added: list[str] = found["with"]
    others = known - len(added)
    said = f"{seen} of the {others} known effects"
    said += " that are not in the model would change something here"
    if seen == others:
        return f"{said}."
    beside = ", or do not go with what was added" if added else ""
    return f"{said}; the others leave no trace in these shots{beside}."
