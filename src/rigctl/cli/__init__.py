"""All commands: where each one is, and what the end of one means."""

from __future__ import annotations

import os
import sys
from typing import Annotated, cast

import typer
from typer.exceptions import TyperException

from rigctl.cli.lazy import Command, Group, LazyGroup
from rigctl.errors import (
    AnalysisInputError,
    ConfigurationError,
    DeviceError,
    NotFoundError,
    RecordingNotConfirmedError,
    RefusedError,
    RigError,
    SettingsError,
    StoreError,
)

BAD_INPUT, REFUSED, NOT_FOUND, INTERRUPTED = 2, 3, 4, 130

_EXIT_CODES: tuple[tuple[type[RigError], int], ...] = (
    (NotFoundError, NOT_FOUND),
    (RefusedError, REFUSED),
    (DeviceError, REFUSED),
    (RecordingNotConfirmedError, REFUSED),
    (StoreError, REFUSED),
    (AnalysisInputError, BAD_INPUT),
    (ConfigurationError, BAD_INPUT),
    (SettingsError, BAD_INPUT),
)

_SWEEP = Group(
    "Fire many shots one after another: rigctl sweep FILE, or with ranges as options.",
    {
        "run": Command("rig.sweep:run", "Run a sweep through the daemon and watch it to its end."),
        "status": Command(
            "rig.sweep:status",
            "Show how far a sweep is, how long it will take, and what became of its steps.",
        ),
        "pause": Command(
            "rig.sweep:pause",
            "Fire nothing more until it is resumed; a shot under way still ends.",
        ),
        "resume": Command("rig.sweep:resume", "Go on at the next step that has not fired."),
        "abort": Command(
            "rig.sweep:abort", "Give it up; a shot under way still ends, and nothing stays armed."
        ),
    },
    otherwise="run",
)
_SHOTS = Group(
    "List stored shots; exclude, include, note and tag them.",
    {
        "list": Command("store.shots:list_shots", "List stored shots, oldest first."),
        "exclude": Command(
            "store.shots:exclude", "Leave shots out of every fit; nothing of them is deleted."
        ),
        "include": Command("store.shots:include", "Let shots count again."),
        "note": Command("store.shots:note", "Put a note in the place of a shot's note."),
        "tag": Command("store.shots:tag", "Give a shot exactly these tags."),
    },
)
_CAMPAIGNS = Group(
    "List stored campaigns; note and tag them.",
    {
        "list": Command(
            "store.campaigns:list_campaigns",
            "List stored campaigns, the one with the latest shot first.",
        ),
        "note": Command("store.campaigns:note", "Put a note in the place of a campaign's note."),
        "tag": Command("store.campaigns:tag", "Give a campaign exactly these tags."),
    },
)
_CONFIG = Group(
    "Configurations of rigs: check them before anything is opened.",
    {
        "check": Command(
            "rig.config:check", "Check configuration files, and name every fault; opens no device."
        )
    },
)
_KEYS = Group(
    "Named keys with scopes: add, list and revoke them.",
    {
        "add": Command("rig.keys:add", "Add a key and print it, this once."),
        "list": Command(
            "rig.keys:list_keys", "List every named key, also those that open nothing any more."
        ),
        "revoke": Command("rig.keys:revoke", "Let a key open nothing any more, at once."),
    },
)
_MODEL = Group(
    "Compare a campaign with the model; find the effect it lacks.",
    {
        "agreement": Command(
            "model.agreement:agreement",
            "Show where the model and the campaign agree, and where they do not.",
        ),
        "fit": Command(
            "model.fit:fit", "Fit e, mu, beta0 and the effects added to all poses of a campaign."
        ),
        "rank": Command(
            "model.rank:ranking", "Rank the effects of the catalogue by their score tests."
        ),
        "launch": Command(
            "model.launch:launch",
            "Fit the launches from the settings, and rank the effects of the launch.",
        ),
        "explain": Command(
            "model.explain:explaining",
            "Find what is missing, add it, and say how much of the error it removes.",
        ),
        "propose": Command(
            "model.propose:proposing",
            "Propose the law that no catalogue holds: what depends on what, and in which shape.",
        ),
        "next": Command(
            "model.next:next_shots",
            "Choose the next shots: to tell two effects apart, or to sharpen a parameter.",
        ),
    },
)
_EFFECT = Group(
    "The effects that a campaign may lack, and effects of your own.",
    {
        "new": Command("model.effects:new", "Write a file to fill in for an effect of your own."),
        "list": Command(
            "model.effects:list_effects", "List all effects with their stages and parameters."
        ),
        "show": Command(
            "model.effects:show",
            "Explain what an effect is, what gives it away, and what it is confused with.",
        ),
    },
)
_CHALLENGE = Group(
    "A campaign that hides an effect, your answer, and the truth.",
    {
        "new": Command(
            "model.challenge:new", "Write a campaign that hides an effect, or two, or none."
        ),
        "commit": Command("model.challenge:commit", "Set down your answer, once and for all."),
        "reveal": Command(
            "model.challenge:reveal", "Reveal what was hidden, and compare your answer with it."
        ),
    },
)
_QUALIFY = Group(
    "The accuracy runs of the thesis on simulated apparatus, truth beside.",
    {
        "stage": Command(
            "frames.qualify:stage", "Move a sphere in quarters of a pixel (figures 4.1 and 4.2)."
        ),
        "drop": Command(
            "frames.qualify:drop", "Take gravity from ten falls of a sphere (table 6.1)."
        ),
        "disk": Command(
            "frames.qualify:disk",
            "Measure angles of a disk that turns at 997 turns a minute (table 6.2).",
        ),
        "depth": Command(
            "frames.qualify:depth",
            "Measure shots with the mirror and with Z constant (table 3.3).",
        ),
    },
)
COMMANDS: dict[str, Command | Group] = {
    "serve": Command(
        "rig.serve:serve",
        "Run the daemon: REST on 127.0.0.1:8486, the simulated rig by default.",
    ),
    "shot": Command("rig.shot:shot", "Fire one shot and print its coefficients."),
    "stop": Command(
        "rig.stop:stop", "Cut the power of every actuator now, and latch; needs no key."
    ),
    "release": Command(
        "rig.stop:release",
        "Give power back after a stop, a fault or an unknown outcome, once a person has looked.",
    ),
    "demo": Command(
        "rig.demo:demo",
        "Find an effect that a simulated rig hides: fire, measure, compare; no daemon needed.",
    ),
    "commission": Command(
        "rig.commission:commission",
        "Walk through what must be seen of a real rig before it fires, and sign it.",
    ),
    "recorder": Command(
        "rig.recorder:recorder",
        "Press a key of the tape recorder, or say how it stands and what is on the tape.",
    ),
    "film": Command(
        "rig.film:film",
        "Say that a camera worked by hand records, and bring its film for the shot.",
    ),
    "firmware": Command(
        "rig.firmware:firmware",
        "Write out the trigger box's firmware, and say how to build and flash it.",
    ),
    "precompile": Command(
        "frames.precompile:precompile",
        "Compile the analysis for this machine once, so that no first shot waits for it: two "
        "processes take some 100 s of a processor each.",
    ),
    "import": Command(
        "store.exchange:import_folder",
        "Take an exchange folder into the catalogue, whole or not at all.",
    ),
    "export": Command(
        "store.exchange:export_folder", "Write a campaign of the catalogue as an exchange folder."
    ),
    "reanalyse": Command(
        "store.reanalyse:reanalyse",
        "Analyse a stored campaign once more; results are added beside those there are.",
    ),
    "verify": Command(
        "store.keeping:verify",
        "Compare all that is stored with its digests, its manifests and its audit.",
    ),
    "recover": Command(
        "store.recover:recover",
        "Build a lost or damaged catalogue again from the shots' folders; fires nothing.",
    ),
    "backup": Command(
        "store.keeping:backup",
        "Copy the store, while a daemon fires or none does, and verify the copy.",
    ),
    "analyse": Command("frames.analyse:analyse", "Measure the collisions in frames."),
    "playback": Command(
        "frames.playback:playback",
        "Give the pictures in a film of a tape's playback their recorded numbers and times.",
    ),
    "calibrate": Command(
        "frames.calibrate:calibrate",
        "Estimate scale, aspect, mirror, roll, distortion and perspective from the shots.",
    ),
    "find-discs": Command(
        "frames.discs:find_discs", "Find all discs of a picture within a range of diameters."
    ),
    "report": Command(
        "store.report:report",
        "Write the results of a campaign: coefficients, figure 7.4, restitution against speed.",
    ),
    "export-nexus": Command(
        "store.exchange_other:export_nexus",
        "Write poses, coefficients and their origin as a NeXus file.",
    ),
    "export-events": Command(
        "store.exchange_other:export_events",
        "Write a campaign as documents of the event model.",
    ),
    "sweep": _SWEEP,
    "shots": _SHOTS,
    "campaigns": _CAMPAIGNS,
    "keys": _KEYS,
    "config": _CONFIG,
    "model": _MODEL,
    "effect": _EFFECT,
    "challenge": _CHALLENGE,
    "qualify": _QUALIFY,
}


app = typer.Typer(
    name="rigctl",
    cls=LazyGroup,
    help="A collision laboratory: fire the rig, film two spheres, measure the impact.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        # What the package's metadata say takes a while to find.
        from importlib.metadata import version  # noqa: PLC0415

        typer.echo(f"rigctl {version('rigctl')}")
        raise typer.Exit


@app.callback()
def rigctl(
    *,
    version: Annotated[
        bool,
        typer.Option("--version", is_eager=True, callback=_show_version, help="Print the version."),
    ] = False,
) -> None:
    """Keep the commands a group, however many there are."""


def run(arguments: list[str]) -> int:
    """Run one command and return its exit code; what failed stands on standard error.

    0 is success, 2 bad input, 3 a rig that refuses or cannot, 4 "not found", 130 an interruption
    by Ctrl-C, 1 anything else.
    """
    # Read where linear algebra is loaded, by the commands: more threads wait for each other there.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        group = cast("LazyGroup", typer.main.get_group(app)).holding(COMMANDS)
        code = group(arguments or ["--help"], prog_name="rigctl", standalone_mode=False)
    except RigError as error:
        typer.echo(f"rigctl: {error.sentence()}", err=True)
        return next((code for kind, code in _EXIT_CODES if isinstance(error, kind)), 1)
    except TyperException as error:
        typer.echo(f"rigctl: {error.format_message()}", err=True)
        return BAD_INPUT
    except typer.Abort as error:
        typer.echo("\nrigctl: ended at a question that was not answered", err=True)
        interrupted = isinstance(error.__context__, KeyboardInterrupt)
        return INTERRUPTED if interrupted else BAD_INPUT
    return code if isinstance(code, int) else 0


def main() -> None:
    """Entry point of the `rigctl` script."""
    sys.exit(run(sys.argv[1:]))
