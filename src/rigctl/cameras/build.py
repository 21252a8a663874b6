"""From the camera section of the configuration to a capture."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from analysis.imaging.playback.sampling import Sampling
from rigctl.cameras.brought import BroughtFilm
from rigctl.cameras.capture import Capture
from rigctl.cameras.capture_folder import CaptureFolder
from rigctl.cameras.chronos import Chronos
from rigctl.cameras.genicam import Genicam, library
from rigctl.cameras.live import LiveCapture
from rigctl.cameras.memory import MemoryCapture
from rigctl.cameras.own import own_capture
from rigctl.cameras.playback import Crop, DigitisedPlayback, ResampledVideo, VideoSource
from rigctl.cameras.running_playback import RunningPlayback
from rigctl.cameras.tape import PictureSource, TapeCapture
from rigctl.cameras.v4l2 import VideoDevice
from rigctl.config import (
    CameraSection,
    ChronosCamera,
    EktaproCamera,
    FilesSource,
    FilmCamera,
    GenicamCamera,
    HidRelay,
    OwnCamera,
    V4l2Source,
)
from rigctl.config import RemoteTriggerSection as ContactSection
from rigctl.devices import hid_relay, serial_line
from rigctl.devices.build import WRITE_TIMEOUT_S, Laboratory, resolved
from rigctl.devices.ektapro import LONGEST_LINE, EktaproLink
from rigctl.devices.roles import Closure
from rigctl.devices.serial_port import SerialPort

RECORDER_BAUD = 115200


def build_capture(section: CameraSection, laboratory: Laboratory | None) -> Capture:
    """Open the camera of a configuration; nothing stays open when a part fails.

    Nothing records yet. A video device is opened when it is first used.

    Raises
    ------
    DeviceError
        A port is absent, busy or forbidden.
    ConfigurationError
        A port is simulated and there is no simulated laboratory; a library or the function of a
        lab's own camera cannot be loaded.
    """
    if isinstance(section, EktaproCamera):
        return _tape(section, laboratory)
    if isinstance(section, ChronosCamera):
        return MemoryCapture(section, Chronos(section, resolved(section.url, laboratory)))
    if isinstance(section, GenicamCamera):
        return LiveCapture(section, Genicam(section, library()))
    if isinstance(section, OwnCamera):
        return own_capture(section)
    if isinstance(section, FilmCamera):
        return BroughtFilm(section)
    camera = VideoDevice(
        section.device,
        rows=section.rows,
        columns=section.columns,
        pixel_format=section.pixel_format,
        input_number=section.input,
        buffers=section.buffers,
    )
    return LiveCapture(section, camera)


def _tape(section: EktaproCamera, laboratory: Laboratory | None) -> Capture:
    with ExitStack() as opened:
        recorder = _recorder(section, laboratory)
        opened.callback(recorder.close)
        contact = None
        if section.remote_trigger is not None:
            contact = _contact(section.remote_trigger, laboratory)
        source = _source(section, recorder, laboratory)
        opened.pop_all()
    return TapeCapture(section, recorder=recorder, source=source, contact=contact)


def _recorder(section: EktaproCamera, laboratory: Laboratory | None) -> EktaproLink:
    port = SerialPort(
        resolved(section.recorder.port, laboratory),
        part="recorder (ektapro-link)",
        baud=RECORDER_BAUD,
        answer_timeout_s=section.recorder.answer_timeout_s,
        longest_line=LONGEST_LINE,
    )
    return EktaproLink(port)


def _contact(section: ContactSection, laboratory: Laboratory | None) -> Closure:
    if isinstance(section, HidRelay):
        backend = None if laboratory is None else laboratory.usb_backend()
        return hid_relay.HidRelay(channel=section.channel, backend=backend)
    port = SerialPort(
        resolved(section.port, laboratory),
        part="remote trigger (serial-line)",
        baud=serial_line.BAUD,
        answer_timeout_s=WRITE_TIMEOUT_S,
    )
    return serial_line.SerialLine(port)


def _source(
    section: EktaproCamera, recorder: EktaproLink, laboratory: Laboratory | None
) -> PictureSource:
    rate = section.picture_rate_hz
    if isinstance(section.source, FilesSource):
        folder = Path(resolved(section.source.folder, laboratory))
        return CaptureFolder(folder, recorder=recorder, picture_rate_hz=rate)
    grabber, crop = _grabber(section, section.source)
    still: VideoSource = grabber
    if section.source.frame_rows is not None:
        still = ResampledVideo(grabber, crop, section.rows, section.columns)
    stepping = DigitisedPlayback(recorder, still, picture_rate_hz=rate)
    if section.source.playback == "step":
        return stepping
    where = (crop.top, crop.left, crop.rows, crop.columns)
    sampling = Sampling(where, section.rows, section.columns, section.source.scan)
    return RunningPlayback(recorder, grabber, sampling, stepping, picture_rate_hz=rate)


def _grabber(section: EktaproCamera, source: V4l2Source) -> tuple[VideoDevice, Crop]:
    """Return the grabber, and which part of its frames holds the picture."""
    rows, columns = source.frame_rows or section.rows, source.frame_columns or section.columns
    grabber = VideoDevice(
        source.device,
        rows=rows,
        columns=columns,
        pixel_format=source.pixel_format,
        input_number=source.input,
    )
    return grabber, Crop(*(source.crop or (0, 0, rows, columns)))
