"""A camera or frame grabber behind the kernel's Video4Linux2 interface."""

from __future__ import annotations

import errno
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rigctl.cameras import v4l2_structs as v4l2
from rigctl.cameras.v4l2_structs import COMPRESSED, GREY_FORMATS, Kernel, LinuxKernel, Mapping
from rigctl.config import PixelFormatName
from rigctl.errors import (
    DeviceAbsentError,
    DeviceAnswerError,
    DeviceBusyError,
    DeviceError,
    DeviceSilentError,
    FramesError,
)

_ABSENT = {errno.ENOENT, errno.ENODEV, errno.ENXIO}
_NOT_YET = {errno.EAGAIN, errno.EINTR}
_COUNTER = 2**32


@dataclass(frozen=True, slots=True, eq=False)
class VideoFrame:
    """One frame from a video device.

    Attributes
    ----------
    pixels
        Grey levels, shape (rows, columns).
    number
        The driver's sequence number, counted on past its 32 bits.
    time_s
        The kernel's time stamp, monotonic seconds: the same clock as `time.monotonic`.
    lost
        Numbers between the frame before and this one that never came or came damaged.
    """

    pixels: NDArray[np.uint8]
    number: int
    time_s: float
    lost: tuple[int, ...]


class VideoDevice:
    """Streams grey frames of one fixed size, 8 bits a pixel. One thread at a time.

    The device node is open while it streams. Drivers may change what they are asked for: the
    format is read back, and any other than this one of exactly this size is refused.

    Parameters
    ----------
    path
        Device node, such as ``/dev/video0``.
    rows, columns
        Size of a frame in pixels.
    pixel_format
        What the driver is asked for (`GREY_FORMATS`).
    input_number
        Input of a frame grabber; cameras have input 0.
    buffers
        How many frames the kernel may hold while nobody reads; a driver may grant fewer.
    kernel
        The system calls.
    clock
        Monotonic seconds.
    """

    def __init__(
        self,
        path: str,
        *,
        rows: int,
        columns: int,
        pixel_format: PixelFormatName = "GREY",
        input_number: int = 0,
        buffers: int = 8,
        kernel: Kernel | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._path, self._rows, self._columns = path, rows, columns
        self._format_name, self._format = pixel_format, GREY_FORMATS[pixel_format]
        self._input, self._wanted_buffers = input_number, buffers
        self._kernel: Kernel = kernel or LinuxKernel()
        self._clock = clock
        self._descriptor: int | None = None
        self._mapped: list[Mapping] = []
        self._line_bytes = columns * self._format.bytes_per_pixel
        self._last: int | None = None
        self._frames = 0
        self._damaged: tuple[int, ...] = ()

    @property
    def name(self) -> str:
        """The device node."""
        return f"video device {self._path}"

    def check(self) -> None:
        """See that the node is there and captures; a device that streams has shown it.

        Raises
        ------
        DeviceError
            It is absent, busy, forbidden, or no capture device.
        """
        if self._descriptor is None:
            descriptor = self._opened()
            self._kernel.close(descriptor)

    def start(self) -> None:
        """Choose the input, set and read back the format, map the buffers, and stream.

        Raises
        ------
        DeviceError
            The device is not there, is held by another program, or refused a step; it is closed.
        FramesError
            The driver grants another format.
        """
        if self._descriptor is not None:
            return
        self._descriptor = self._opened()
        try:
            self._choose_input()
            self._set_format()
            self._map_buffers()
            self._call(v4l2.STREAMON, bytearray(v4l2.INTEGER.pack(v4l2.CAPTURE)), "start")
        except BaseException:
            self.stop()
            raise
        self._last, self._frames, self._damaged = None, 0, ()

    def read(self, timeout_s: float) -> VideoFrame:
        """Return the next whole frame; damaged ones are passed over and counted as lost.

        Raises
        ------
        DeviceSilentError
            No whole frame came in time.
        DeviceAnswerError
            The time stamp is not of the monotonic clock, or a sequence number came twice.
        DeviceError
            The device went away, or does not stream.
        """
        deadline = self._clock() + timeout_s
        while (left_s := deadline - self._clock()) > 0:
            found = self._next(left_s)
            if found is None:
                continue
            filled, pixels = found
            number, gap = self._counted(filled)
            if pixels is not None:
                # Also those before which an earlier call gave up: a slow camera's next whole frame
                # may come after its time limit.
                lost, self._damaged = (*self._damaged, *gap), ()
                return VideoFrame(pixels, number, filled.time_s, lost)
            self._damaged = (*self._damaged, *gap, number)
        raise DeviceSilentError(
            "no whole frame came",
            part=self.name,
            value=f"{len(self._damaged)} damaged or lost",
            limit=f"{timeout_s:g} s",
            todo="check the camera's cable, its trigger and its frame rate",
        )

    def stop(self) -> None:
        """Stop streaming, unmap and close. Harmless when nothing streams."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is None:
            return
        # Closing the node frees everything, so what fails before is of no account.
        with suppress(OSError):
            argument = bytearray(v4l2.INTEGER.pack(v4l2.CAPTURE))
            self._kernel.ioctl(descriptor, v4l2.STREAMOFF, argument)
        for mapped in self._mapped:
            mapped.close()
        self._mapped = []
        self._kernel.close(descriptor)

    def close(self) -> None:
        """Release the device. Safe to call twice."""
        self.stop()

    def _opened(self) -> int:
        try:
            descriptor = self._kernel.open(self._path)
        except OSError as error:
            raise self._named(error, "open") from error
        capability = bytearray(v4l2.CAPABILITY.size)
        try:
            self._kernel.ioctl(descriptor, v4l2.QUERYCAP, capability)
        except OSError as error:
            self._kernel.close(descriptor)
            raise self._named(error, "query") from error
        if not v4l2.can_stream(capability):
            self._kernel.close(descriptor)
            raise DeviceAnswerError(
                "the device does not capture by streaming",
                part=self.name,
                todo="name another device node in the configuration",
            )
        return descriptor

    def _choose_input(self) -> None:
        try:
            self._call(v4l2.S_INPUT, bytearray(v4l2.INTEGER.pack(self._input)), "choose the input")
        except DeviceError as error:
            cause = error.__cause__
            # A camera with nothing to choose from need not know the request.
            if self._input or not isinstance(cause, OSError) or cause.errno != errno.ENOTTY:
                raise

    def _set_format(self) -> None:
        argument = v4l2.ask_format(self._columns, self._rows, self._format.code)
        self._call(v4l2.S_FMT, argument, "set the format")
        granted = v4l2.granted_format(argument)
        wanted = (self._columns, self._rows, self._format.code)
        fits = (granted.width, granted.height, granted.code) == wanted
        whole = granted.line_bytes * self._rows <= granted.image_bytes
        if not (fits and whole and granted.line_bytes >= self._line_bytes):
            raise self._other_format(granted)
        self._line_bytes = granted.line_bytes

    def _other_format(self, granted: v4l2.PixelFormat) -> FramesError:
        code = granted.code.to_bytes(4, "little").decode("latin-1")
        todo = "set rows, columns and pixel_format in the configuration to what the camera can do"
        if code in COMPRESSED:
            todo = f"{code} is compressed and changes grey levels: set pixel_format to another one"
        return FramesError(
            "the driver grants another format",
            part=self.name,
            value=f"{granted.height} rows, {granted.width} columns, {code!r}, "
            f"{granted.line_bytes} bytes a line, {granted.image_bytes} an image",
            limit=f"{self._rows} rows, {self._columns} columns, {self._format_name!r}",
            todo=todo,
        )

    def _map_buffers(self) -> None:
        argument = v4l2.ask_buffers(self._wanted_buffers)
        self._call(v4l2.REQBUFS, argument, "request buffers")
        count = v4l2.granted_buffers(argument)
        if count < 2:
            raise DeviceAnswerError(
                "the driver grants too few buffers",
                part=self.name,
                value=str(count),
                limit="at least 2",
                todo="end other programs that use the camera",
            )
        for index in range(count):
            answer = v4l2.buffer(index)
            self._call(v4l2.QUERYBUF, answer, "query a buffer")
            length, offset = v4l2.mapping(answer)
            self._mapped.append(self._map(length, offset))
            self._call(v4l2.QBUF, v4l2.buffer(index), "queue a buffer")

    def _map(self, length: int, offset: int) -> Mapping:
        try:
            return self._kernel.map(self._streaming(), length, offset)
        except OSError as error:
            raise self._named(error, "map a buffer") from error

    def _next(self, timeout_s: float) -> tuple[v4l2.Dequeued, NDArray[np.uint8] | None] | None:
        """Return one filled buffer and its pixels, None instead of these when it is damaged."""
        try:
            if not self._kernel.readable(self._streaming(), timeout_s):
                return None
            answer = v4l2.buffer()
            self._kernel.ioctl(self._streaming(), v4l2.DQBUF, answer)
        except OSError as error:
            if error.errno in _NOT_YET:
                return None
            raise self._named(error, "take a frame") from error
        filled = v4l2.dequeued(answer)
        size = self._line_bytes * self._rows
        pixels = None
        if not filled.damaged and filled.bytes_used >= size:
            data = np.frombuffer(self._mapped[filled.index][:size], dtype=np.uint8)
            lines = data.reshape(self._rows, self._line_bytes)
            pixels = self._format.grey(lines, self._columns)
        self._call(v4l2.QBUF, v4l2.buffer(filled.index), "queue a buffer")
        if not filled.monotonic:
            raise DeviceAnswerError(
                "the driver's time stamps are not of the monotonic clock",
                part=self.name,
                todo="use another driver: frames could not be placed against the fire",
            )
        return filled, pixels

    def _counted(self, filled: v4l2.Dequeued) -> tuple[int, tuple[int, ...]]:
        self._frames += 1
        if self._last is None:
            self._last = filled.sequence
            return self._last, ()
        step = (filled.sequence - self._last) % _COUNTER
        if step == 0 or step >= _COUNTER // 2:
            raise DeviceAnswerError(
                "a frame number came twice or went back",
                part=self.name,
                value=str(filled.sequence),
                limit=f"above {self._last % _COUNTER}",
                todo="use another driver: lost frames could not be told",
            )
        before, self._last = self._last, self._last + step
        # Some drivers count what passed before streaming began between their first two frames.
        gap = range(before + 1, self._last) if self._frames > 2 else range(0)
        return self._last, tuple(gap)

    def _streaming(self) -> int:
        if self._descriptor is None:
            raise DeviceError("the device does not stream", part=self.name, todo="start it first")
        return self._descriptor

    def _call(self, request: int, argument: bytearray, deed: str) -> None:
        try:
            self._kernel.ioctl(self._streaming(), request, argument)
        except OSError as error:
            raise self._named(error, deed) from error

    def _named(self, error: OSError, deed: str) -> DeviceError:
        what = f"cannot {deed} ({error.strerror})"
        if error.errno == errno.EBUSY:
            return DeviceBusyError(what, part=self.name, todo="end the other program")
        if error.errno in _ABSENT:
            return DeviceAbsentError(what, part=self.name, todo="check cable and device node")
        if error.errno in {errno.EACCES, errno.EPERM}:
            return DeviceError(what, part=self.name, todo="add the user to the group video")
        return DeviceError(what, part=self.name, todo="check what the camera can do")
