"""GenICam cameras (GigE Vision, USB3 Vision) through the library Aravis, an optional extra."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np

from rigctl.cameras.v4l2 import VideoFrame
from rigctl.config import GenicamCamera
from rigctl.errors import (
    ConfigurationError,
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceSilentError,
)

Untyped: TypeAlias = Any
"""Objects of the library, which has no types."""

_VERSION = "0.8"
_FAKE = "Fake_"
"""What the identifier of the library's own fake camera begins with."""
_LAST_BLOCK = 65_535
_ONE_S = 1e-9
"""Aravis counts time in nanoseconds."""


def library() -> Untyped:
    """Return the library.

    Raises
    ------
    ConfigurationError
        It is not installed.
    """
    try:
        import gi  # noqa: PLC0415  # an extra, needed by no other camera

        gi.require_version("Aravis", _VERSION)
        from gi.repository import Aravis  # noqa: PLC0415
    except (ImportError, ValueError) as error:
        raise ConfigurationError(
            f"the library Aravis is missing: {error}",
            part="camera.kind",
            value="'genicam'",
            todo="apt install gir1.2-aravis-0.8 and pip install 'rigctl[genicam]'",
        ) from error
    return Aravis


class Genicam:
    """A `VideoSource` on a GenICam camera: each frame with the camera's own number and time.

    Parameters
    ----------
    settings
        Camera, size, rate and number of buffers.
    aravis
        The library, loaded.
    clock
        Monotonic seconds.
    """

    def __init__(
        self,
        settings: GenicamCamera,
        aravis: Untyped,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._settings, self._aravis, self._clock = settings, aravis, clock
        self._camera: Untyped = None
        self._stream: Untyped = None
        self._last: int | None = None
        self._block: int | None = None

    @property
    def name(self) -> str:
        """Kind and camera."""
        return f"camera (genicam {self._settings.camera_id})"

    def check(self) -> None:
        """Open the camera if it is not open, and ask for its model.

        Raises
        ------
        DeviceAbsentError
            It is not there.
        """
        try:
            self._opened().get_model_name()
        except Exception as error:
            self._camera = None
            raise self._absent(error) from error

    def start(self) -> None:
        """Set size, format and rate, see that the camera took them, and stream.

        Raises
        ------
        DeviceError
            It is not there, or grants something else.
        """
        self.stop()
        camera, payload = self._set()
        try:
            self._stream = self._made_stream(camera)
            for _ in range(self._settings.buffers):
                self._stream.push_buffer(self._aravis.Buffer.new_allocate(payload))
            camera.start_acquisition()
        except Exception as error:
            self._camera = self._stream = None
            raise self._absent(error) from error
        self._last = self._block = None

    def read(self, timeout_s: float) -> VideoFrame:
        """Return the next whole frame.

        Raises
        ------
        DeviceSilentError
            None came in time.
        """
        deadline = self._clock() + timeout_s
        while self._stream is not None and (left_s := deadline - self._clock()) > 0:
            buffer = self._stream.timeout_pop_buffer(round(left_s * 1e6))
            if buffer is None:
                break
            try:
                if buffer.get_status() == self._aravis.BufferStatus.SUCCESS:
                    return self._frame(buffer)
            finally:
                self._stream.push_buffer(buffer)
        raise DeviceSilentError(
            "no frame came", part=self.name, limit=f"{timeout_s:g} s", todo="check its cable"
        )

    def stop(self) -> None:
        """Stop streaming; harmless when nothing streams."""
        if self._stream is not None and self._camera is not None:
            try:
                self._camera.stop_acquisition()
            except Exception:  # noqa: BLE001 - the library's errors have no type before it is loaded
                self._camera = None
        self._stream = None

    def close(self) -> None:
        """Release the camera. Safe to call twice."""
        self.stop()
        self._camera = None

    def _set(self) -> tuple[Untyped, int]:
        """Set size, format and rate; return the camera and the bytes of a frame."""
        settings = self._settings
        try:
            camera = self._opened()
            largest = (camera.get_width_bounds()[1], camera.get_height_bounds()[1])
            camera.set_region(0, 0, settings.columns, settings.rows)
            camera.set_pixel_format_from_string(settings.pixel_format)
            camera.set_frame_rate(settings.frame_rate_hz)
            _, _, columns, rows = camera.get_region()
            granted = (columns, rows, camera.get_pixel_format_as_string())
            payload = int(camera.get_payload())
        except Exception as error:
            self._camera = None
            raise self._absent(error) from error
        wanted = (settings.columns, settings.rows, settings.pixel_format)
        # Not every camera refuses a size that it does not have.
        if granted != wanted or settings.columns > largest[0] or settings.rows > largest[1]:
            raise DeviceAnswerError(
                "the camera has another size or format",
                part=self.name,
                value=f"{granted}, at most {largest[0]} by {largest[1]}",
                limit=f"{wanted} (columns, rows, format)",
                todo="correct rows and columns in the configuration",
            )
        return camera, payload

    def _opened(self) -> Untyped:
        if self._camera is not None and self._has_lost_control():
            self._camera = None
        if self._camera is None:
            if self._settings.camera_id.startswith(_FAKE):
                self._aravis.enable_interface("Fake")
            self._camera = self._aravis.Camera.new(self._settings.camera_id)
        return self._camera

    def _has_lost_control(self) -> bool:
        """Say whether a GigE camera was away meanwhile: it answers, and obeys nobody."""
        device = self._camera.get_device()
        return isinstance(device, self._aravis.GvDevice) and not device.is_controller()

    def _made_stream(self, camera: Untyped) -> Untyped:
        """Return a stream; a GigE camera's by plain UDP with as much room as the frames need.

        The library's raw sockets need rights that a daemon has not, and see nothing of a camera on
        the same host; with the system's own room, large frames lose packets.
        """
        device = camera.get_device()
        if isinstance(device, self._aravis.GvDevice):
            device.set_stream_options(self._aravis.GvStreamOption.PACKET_SOCKET_DISABLED)
        stream = camera.create_stream(None, None)
        if isinstance(stream, self._aravis.GvStream):
            stream.set_property("socket-buffer", self._aravis.GvStreamSocketBuffer.AUTO)
        return stream

    def _frame(self, buffer: Untyped) -> VideoFrame:
        rows, columns = self._settings.rows, self._settings.columns
        data = np.frombuffer(buffer.get_data(), np.uint8, rows * columns)
        number, lost = self._counted(int(buffer.get_frame_id()))
        time_s = buffer.get_timestamp() * _ONE_S
        return VideoFrame(data.reshape(rows, columns).copy(), number, time_s, lost)

    def _counted(self, block: int) -> tuple[int, tuple[int, ...]]:
        """Return a frame's number, counted on past the 16 bits of GigE Vision, and what was lost.

        Numbers of 16 bits go from 65535 to 1; some cameras have a 0 between.
        """
        before, self._block = self._block, block
        if before is None or self._last is None:
            self._last = block
            return block, ()
        step = block - before
        if step <= 0:
            step = step % _LAST_BLOCK or 1
        last, self._last = self._last, self._last + step
        return self._last, tuple(range(last + 1, self._last))

    def _absent(self, error: Exception) -> DeviceAbsentError:
        # Takes a second: cameras on the network have that long to answer.
        self._aravis.update_device_list()
        count = self._aravis.get_n_devices()
        there = ", ".join(str(self._aravis.get_device_id(k)) for k in range(count))
        return DeviceAbsentError(
            f"the camera cannot be used: {error}",
            part=self.name,
            todo=f"check its cable and camera.camera_id; cameras that answer: {there or 'none'}",
        )
