"""The steps of one rig's commissioning, from its configuration, in the order that is safe."""

from __future__ import annotations

from collections.abc import Iterator

from rigctl.commissioning.step import Act, Part, Step, lowest
from rigctl.config import SIMULATED, Configuration, EktaproCamera, FilmCamera, TriggerBox
from rigctl.rig.stopping.box_watch import MADE_SAFE
from rigctl.rig.stopping.dead_man import CUT_BY_DEAD_MAN

_LONGEST_DELAY_US = 5000.0


def steps_of(configuration: Configuration) -> tuple[Step, ...]:
    """Return every step of a rig, in the order in which they are safe."""
    return (
        *_cut_off(configuration),
        *_watches(configuration),
        *_trigger(configuration),
        *_regulator(configuration),
        *_slide(configuration),
        *_camera(configuration),
        *_interlocks(configuration),
        *_stop(configuration),
    )


def _cut_off(rig: Configuration) -> Iterator[Step]:
    part, sections = Part.CUT_OFF, ("cut_off", "trigger.power_cut")
    drop = " Both spheres would drop: leave the tubes empty." if _drops(rig) else ""
    low = lowest(rig)
    yield Step(
        "supply",
        part,
        "Supply on",
        "Spheres out, air shut off behind the regulators, a lamp or an oscilloscope in the place "
        f"of each actuator. Measure the actuators' supply.{drop}",
        "Full voltage, and nothing has moved.",
        Act.RELEASE,
        sections=sections,
    )
    yield Step(
        "stop",
        part,
        "The stop cuts",
        "Watch the supply while the daemon stops the rig.",
        "No voltage, within the time that your actuators need to move.",
        Act.STOP,
        sections=sections,
    )
    yield Step(
        "stop-latched",
        part,
        "A stop holds",
        "Leave the rig stopped; the daemon tries to arm it.",
        "Still no voltage, and the rig refuses to arm.",
        Act.REFUSED,
        low,
        ("estop",),
        sections,
    )
    yield Step(
        "release",
        part,
        "The release gives the power back",
        "Watch the supply and all outputs while the daemon releases the rig.",
        "Full voltage is back, and no output gave a pulse.",
        Act.RELEASE,
        sections=sections,
    )
    boxed = isinstance(rig.trigger, TriggerBox)
    yield Step(
        "own-switch",
        part,
        "Your own switch",
        "Open the switch that a hand reaches, in series with the cut-off.",
        "No voltage" + (", and arming is refused at `trigger`." if boxed else "."),
        Act.REFUSED if boxed else None,
        low if boxed else None,
        ("trigger:",) if boxed else (),
        sections,
    )
    yield Step(
        "cut-off-unplugged",
        part,
        "The cut-off without its cable",
        "Close your switch, then pull the cut-off's USB plug.",
        "No voltage, and arming is refused at `cut_off`.",
        Act.REFUSED,
        low,
        ("cut_off:",),
        sections,
    )
    yield Step(
        "cut-off-back",
        part,
        "The cut-off plugged in again",
        "Put the plug back; the daemon stops the rig and releases it.",
        "Full voltage, and no output gave a pulse.",
        Act.STOP_RELEASE,
        sections=sections,
    )


def _watches(rig: Configuration) -> Iterator[Step]:
    if _drops(rig):
        return
    watched = rig.cut_off.port.startswith("/")
    if rig.cut_off.dead_man:
        yield Step(
            "dead-man",
            Part.CUT_OFF,
            "The dead man",
            "End the daemon with `kill -9`, start it again, read why it is latched, release it. "
            "Then `kill -STOP` it for two seconds and `kill -CONT` it; the daemon reads why it "
            "stopped, and releases the rig.",
            "The voltage goes within a second of each kill, and no output gave a pulse.",
            Act.LATCHED if watched else None,
            latched_by=(CUT_BY_DEAD_MAN, MADE_SAFE),
            sections=("cut_off", "trigger.power_cut"),
        )
    if isinstance(rig.trigger, TriggerBox) and rig.trigger.heartbeat:
        real = not rig.trigger.port.startswith(SIMULATED)
        yield Step(
            "heartbeat",
            Part.TRIGGER,
            "The box watches its host",
            "Pull the trigger box's USB plug for two seconds and put it back. The daemon reads why "
            "the rig stopped, and releases it."
            if real
            else "Nothing: the box of simulated ports dies with the daemon and hears no heartbeat.",
            "The rig has stopped by itself, and says that the box has made itself safe."
            if real
            else "That this is a rehearsal: answer yes.",
            Act.LATCHED if real else None,
            latched_by=(MADE_SAFE,),
            sections=("trigger",),
            firmware=True,
        )


def _trigger(rig: Configuration) -> Iterator[Step]:
    part, low = Part.TRIGGER, lowest(rig)
    yield Step(
        "trigger-back",
        part,
        "Nothing fires by itself",
        "Unplug the trigger and plug it in again five times, power it off and on, reset it.",
        "No output gave a pulse, and the rig arms again.",
        Act.BACK,
        low,
        sections=("trigger",),
        firmware=True,
    )
    yield from _line(rig, part, "trigger", ("trigger", "SAFE", "box"), ("trigger",))
    width = f", {rig.trigger.pulse_us} us long" if isinstance(rig.trigger, TriggerBox) else ""
    yield Step(
        "pulses",
        part,
        "One shot, one pulse",
        "Watch both outputs in single-shot mode. The daemon fires once.",
        f"One pulse on each output{width}, and no second one.",
        Act.FIRE,
        low,
        sections=("trigger",),
        firmware=True,
    )
    delay_us = min(_LONGEST_DELAY_US, rig.limits.delay_us[1])
    # The pair of relays cannot time less than a command takes on the wire.
    if delay_us >= (1.0 if isinstance(rig.trigger, TriggerBox) else _LONGEST_DELAY_US):
        yield Step(
            "delay",
            part,
            "The second pulse later",
            "Watch both outputs in single-shot mode. The daemon fires once.",
            f"The pulse on b comes {delay_us / 1000:g} ms after that on a.",
            Act.FIRE,
            lowest(rig, delay_us=float(int(delay_us))),
            sections=("trigger", "limits.delay_us"),
            firmware=True,
        )


def _regulator(rig: Configuration) -> Iterator[Step]:
    if rig.regulator is None:
        return
    raised = lowest(rig, share=0.25)
    sections = ("regulator", "limits.pressure_kpa", "limits.pressure_tolerance_kpa")
    yield Step(
        "pressure",
        Part.REGULATOR,
        "Both pressures",
        "Read both gauges once the daemon has set the regulators.",
        f"{raised.pressure_a_kpa:g} kPa on each, as the daemon reads.",
        Act.SET,
        raised,
        sections=sections,
    )
    yield from _line(rig, Part.REGULATOR, "regulator", ("pressure", "regulator"), ("regulator",))


def _slide(rig: Configuration) -> Iterator[Step]:
    if rig.slide is None:
        return
    raised = lowest(rig, share=0.25)
    yield Step(
        "offset",
        Part.SLIDE,
        "The offset",
        "Measure how far tube b stands below tube a once the daemon has moved the slide.",
        f"{raised.offset_mm:g} mm, as the daemon reads.",
        Act.SET,
        raised,
        sections=("slide", "limits.offset_mm", "limits.offset_tolerance_mm"),
    )
    yield from _line(rig, Part.SLIDE, "slide", ("offset", "slide"), ("slide",))


def _camera(rig: Configuration) -> Iterator[Step]:
    part, low = Part.CAMERA, lowest(rig)
    before = rig.camera.frames_before_mark
    by_hand = isinstance(rig.camera, FilmCamera)
    film = (
        " once you have started the film and said so (`rigctl film --records` in another terminal,"
        " or the page Film); bring the film"
    )
    yield Step(
        "frames",
        part,
        "Frames about the pulse",
        "Put a lamp on output a into the picture. The daemon fires once"
        f"{film if by_hand else ''}; look at the shot.",
        f"The lamp lights up in frame {before}, one frame more or less, in both views.",
        Act.FIRE,
        low,
        sections=("camera",),
        firmware=True,
    )
    if by_hand:
        # It has no cable, and answers nobody: only the word of a person can be missing.
        yield Step(
            "nobody-films",
            part,
            "Nobody says that the camera records",
            "Let the daemon wait, or end its wait with `rigctl film --gives-up`. It tries to fire.",
            "No output gave a pulse.",
            Act.UNRECORDED,
            low,
            sections=("camera",),
        )
        return
    words = ("camera", "recorder")
    yield from _line(rig, part, "camera", words, ("camera",))
    if isinstance(rig.camera, EktaproCamera) and rig.camera.remote_trigger is not None:
        yield Step(
            "remote-trigger",
            part,
            "The tape's remote trigger",
            "Pull the cable of the remote trigger at the imager. The daemon tries to fire.",
            "No output gave a pulse: the tape did not start.",
            Act.UNRECORDED,
            low,
            sections=("camera",),
        )


def _interlocks(rig: Configuration) -> Iterator[Step]:
    part, low, limits = Part.INTERLOCKS, lowest(rig), rig.limits
    yield Step(
        "clock",
        part,
        "The host's clock",
        f"Put every cable back. Set the host's clock by {max(60.0, 2 * limits.clock_step_s):g} s.",
        "Arming is refused at `clock`.",
        Act.REFUSED,
        low,
        ("clock:",),
        ("limits.clock_step_s",),
    )
    yield Step(
        "clock-right",
        part,
        "The host's clock set right",
        "Set the clock right again.",
        "Arming is refused at `clock` once more: this was a step too.",
        Act.REFUSED,
        low,
        ("clock:",),
        ("limits.clock_step_s",),
    )
    yield Step(
        "readings",
        part,
        "What the rig reads",
        "Compare each reading with the thing itself: gauges, offset, free space of the disk.",
        "Each reading is right, and each limit is the one that you mean.",
        Act.BACK,
        low,
        sections=("limits", "store.folder"),
    )
    if 0 < limits.cool_down_s <= limits.settle_timeout_s:
        yield Step(
            "cool-down",
            part,
            "The pause between shots",
            "The daemon fires once and arms at once again.",
            f"It waited {limits.cool_down_s:g} s, which are enough to step back from the tubes.",
            Act.REST,
            low,
            sections=("limits.cool_down_s",),
        )


def _stop(rig: Configuration) -> Iterator[Step]:
    part = Part.STOP
    if rig.slide is not None:
        yield Step(
            "stop-in-motion",
            part,
            "A stop brings everything to rest",
            "Watch slide and gauges. The daemon sets both, then stops the rig.",
            "No voltage, the slide halts, both gauges fall to nothing.",
            Act.SET_STOP,
            lowest(rig, share=0.5),
            sections=("cut_off", "regulator", "slide"),
        )
    yield Step(
        "stop-by-hand",
        part,
        "Every way to stop",
        "Stop the rig by the page's button, by Ctrl + . and by `rigctl stop`, and release it after "
        "each.",
        "The voltage goes each time, within the time that your actuators need to move.",
        sections=("cut_off", "service"),
    )
    yield Step(
        "released",
        part,
        "At the end",
        "Every cable in its place. The daemon releases the rig, arms and disarms it.",
        "Nothing moved but slide and pressure.",
        Act.BACK,
        lowest(rig),
        sections=("cut_off",),
    )


def _line(
    rig: Configuration,
    part: Part,
    word: str,
    refused_by: tuple[str, ...],
    sections: tuple[str, ...],
) -> Iterator[Step]:
    """Give the steps of a cable: pulled, nothing arms; plugged in again, the rig arms."""
    low = lowest(rig)
    yield Step(
        f"{word}-unplugged",
        part,
        f"The {word} without its cable",
        f"Pull the cable of the {word}. The daemon tries to arm.",
        f"The rig refuses and names the {word}; no output gave a pulse.",
        Act.REFUSED,
        low,
        refused_by,
        sections,
    )
    yield Step(
        f"{word}-plugged-in",
        part,
        f"The {word} plugged in again",
        "Put the cable back. The daemon releases the rig where that is needed, and arms it.",
        "The rig arms, without a restart, and no output gave a pulse.",
        Act.BACK,
        low,
        sections=sections,
    )


def _drops(rig: Configuration) -> bool:
    return rig.trigger.power_cut == "fires"
