"""Everything that runs: opened in order, closed in the reverse, with the rig left safe."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from rigctl.cameras.brought import BroughtFilm
from rigctl.cameras.build import build_capture
from rigctl.cameras.keypad import Keypad
from rigctl.cameras.tape import TapeCapture
from rigctl.commissioning.answers import Answers
from rigctl.commissioning.gate import Gate
from rigctl.commissioning.step import Part
from rigctl.commissioning.walk import Commissioning
from rigctl.config import SIMULATED, Configuration, TriggerBox
from rigctl.devices import build
from rigctl.devices.roles import Actuators, FirmwareQuery, HeartbeatWatch
from rigctl.errors import DeviceError
from rigctl.jobs import Jobs
from rigctl.laboratory import Laboratory, open_laboratory
from rigctl.measuring.analysing import Analyser, Awaited, Compiling
from rigctl.model.own_effects import OwnEffects
from rigctl.opening import own_store
from rigctl.rig.machine import Rig
from rigctl.rig.recovery import Recovery
from rigctl.rig.stopping.box_watch import BoxWatch
from rigctl.rig.stopping.dead_man import DeadMan
from rigctl.rig.stopping.watch import Watch
from rigctl.store import Store, SweepRecord
from rigctl.sweeps.runner import SweepRunner

LABORATORY_FOLDER = "laboratory"
"""Folder of the simulated laboratory, inside the store's."""


@dataclass(frozen=True, slots=True)
class Daemon:
    """A running rig with its store, jobs and sweeps, and the repairs made at its start.

    `laboratory` simulates the hardware, None on a real rig; `analyse` queues a
    stored shot for analysis and returns at once, `analyse_by` by a method of choice;
    `cancel_analysis` ends that of a shot, whose frames and results stay; `awaited` is how long a
    shot has waited for its analysis, None where it does not wait;
    `prepare_analysis` has a worker load what the first shot needs; `compiling`
    gives the progress of compiling that an analysis waits for, None where none does; `jobs` runs
    all other long work; `commissioning` is what people must have seen of a real rig; `keypad` that
    of a tape recorder, None with another camera; `film` takes the films that people bring, None
    with a camera that the rig works itself; `offered` are the sweeps that wait to be resumed.
    """

    configuration: Configuration
    rig: Rig
    store: Store
    recovery: Recovery
    laboratory: Laboratory | None
    analyse: Callable[[str], None]
    analyse_by: Callable[[str, str], None]
    cancel_analysis: Callable[[str], None]
    awaited: Callable[[str], Awaited | None]
    prepare_analysis: Callable[[], None]
    compiling: Callable[[], Compiling | None]
    jobs: Jobs
    sweeps: SweepRunner
    commissioning: Commissioning
    keypad: Keypad | None
    film: BroughtFilm | None
    offered: tuple[SweepRecord, ...]


@contextmanager
def open_daemon(configuration: Configuration) -> Iterator[Daemon]:
    """Open the store, the devices and the rig; close them all when the block ends, however it does.

    On the way out a sweep is paused, a shot under way ends within its bounds, the trigger is made
    safe and the power is cut (where a cut lets no sphere go), before anything is closed.

    Raises
    ------
    StoreError
        The store cannot be used, or another process owns it.
    ConfigurationError
        The factory of the simulated laboratory does not do, or the folder of effects is none.
    DeviceError
        A device is absent, busy or forbidden.
    """
    OwnEffects.of(configuration).check()
    with ExitStack() as opened:
        store = own_store(configuration)
        opened.callback(store.close)
        laboratory = open_laboratory(
            configuration.simulation, configuration.scene, store.path / LABORATORY_FOLDER
        )
        if laboratory is not None:
            opened.callback(laboratory.close)
        devices = _open_devices(configuration, laboratory, opened)
        capture = build_capture(configuration.camera, laboratory)
        opened.callback(capture.close)
        section = configuration.analysis
        analyser = Analyser(
            store, workers=section.workers, method=section.method, timeout_s=section.timeout_s
        )
        opened.callback(analyser.close)
        jobs = Jobs()
        opened.callback(jobs.close)
        answers = Answers(store)
        gate = Gate(configuration, answers, lambda: _firmware(devices))
        rig = Rig(
            configuration,
            devices,
            capture,
            store,
            analyse=analyser.submit,
            watches=_watches(configuration, devices),
            permit=gate,
        )
        opened.callback(rig.close)
        film = capture if isinstance(capture, BroughtFilm) else None
        if film is not None:
            # Before the rig closes, which lets a shot end: nobody will bring its film any more.
            opened.callback(film.close)
        recovery = rig.recover()
        sweeps = SweepRunner(rig, store, configuration)
        opened.callback(sweeps.close)
        offered = sweeps.recover()
        yield Daemon(
            configuration=configuration,
            rig=rig,
            store=store,
            recovery=recovery,
            laboratory=laboratory,
            analyse=analyser.submit,
            analyse_by=analyser.submit_by,
            cancel_analysis=analyser.cancel,
            awaited=analyser.awaited,
            prepare_analysis=analyser.prepare,
            compiling=lambda: analyser.compiling,
            jobs=jobs,
            sweeps=sweeps,
            commissioning=Commissioning(configuration, rig, gate, answers),
            keypad=Keypad(capture) if isinstance(capture, TapeCapture) else None,
            film=film,
            offered=offered,
        )


def _open_devices(
    configuration: Configuration, laboratory: Laboratory | None, opened: ExitStack
) -> Actuators:
    actuators = build.build_actuators(configuration, laboratory)
    for device in (actuators.cut_off, actuators.trigger, actuators.regulator, actuators.slide):
        if device is not None:
            opened.callback(device.close)
    return actuators


def _firmware(devices: Actuators) -> dict[str, str]:
    """Return what the devices say of their firmware; one that is silent is left out."""
    trigger = devices.trigger
    if not isinstance(trigger, FirmwareQuery):
        return {}
    try:
        return {Part.TRIGGER: trigger.firmware()}
    except DeviceError:
        return {}


def _watches(configuration: Configuration, devices: Actuators) -> tuple[Watch, ...]:
    """Return what acts when the daemon dies: nothing where a cut lets spheres go."""
    relay, trigger = configuration.cut_off, configuration.trigger
    if trigger.power_cut != "holds":
        return ()
    watches: list[Watch] = []
    # Simulated devices die with the daemon; a pyserial URL cannot be opened a second time.
    if relay.dead_man and relay.port.startswith("/"):
        watches.append(DeadMan(relay.port, relay.channel))
    if isinstance(trigger, TriggerBox) and trigger.heartbeat:
        real = not trigger.port.startswith(SIMULATED)
        if real and isinstance(devices.trigger, HeartbeatWatch):
            watches.append(BoxWatch(devices.trigger))
    return tuple(watches)
