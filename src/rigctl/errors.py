"""The one tree of errors: what happened, to which part, beyond which limit, and what to do next."""

from __future__ import annotations

from typing import ClassVar

from analysis.errors import shortened


class RigError(Exception):
    """Anything the daemon refuses or fails at, in words an operator can act on.

    Parameters
    ----------
    what
        One clause without a full stop: what happened.
    part
        The device, file or field it happened to.
    value, limit
        What was found and what was allowed, each with its unit in the text.
    todo
        What the operator does next.
    shot
        The shot it belongs to, where there is one.

    Notes
    -----
    `code` is stable: programs that talk to the REST interface rely on it.
    """

    code: ClassVar[str] = "rig-error"

    def __init__(
        self,
        what: str,
        *,
        part: str | None = None,
        value: str | None = None,
        limit: str | None = None,
        todo: str | None = None,
        shot: str | None = None,
    ) -> None:
        self.what = shortened(what)
        self.part, self.value, self.limit, self.todo = (
            None if text is None else shortened(text) for text in (part, value, limit, todo)
        )
        self.shot = shot
        super().__init__(self.sentence())

    def sentence(self) -> str:
        """Return the error as one line of text."""
        text = f"{self.part}: {self.what}" if self.part else self.what
        if self.value is not None:
            text += f" (found {self.value}"
            text += f", allowed {self.limit})" if self.limit is not None else ")"
        elif self.limit is not None:
            text += f" (limit {self.limit})"
        if self.shot is not None:
            text += f" [shot {self.shot}]"
        return f"{text}; {self.todo}" if self.todo else text


class ConfigurationError(RigError):
    """The configuration file has an invalid value."""

    code = "configuration"


class SettingsError(RigError):
    """A setting lies outside what the configuration allows."""

    code = "settings-out-of-range"


class DeviceError(RigError):
    """A device did not carry out its command; the rig goes to FAULT."""

    code = "device"


class DeviceBusyError(DeviceError):
    """Another program holds the port."""

    code = "device-busy"


class DeviceAbsentError(DeviceError):
    """The port or the USB device is not there, or went away."""

    code = "device-absent"


class DeviceSilentError(DeviceError):
    """No complete answer came within the stated time."""

    code = "device-silent"


class DeviceAnswerError(DeviceError):
    """An answer came that does not follow the device's protocol."""

    code = "device-answer"


class FireOutcomeUnknownError(DeviceError):
    """The fire command may or may not have reached the trigger; it is never sent again."""

    code = "fire-outcome-unknown"


class RecordingNotConfirmedError(RigError):
    """The camera did not confirm that it records; nothing may fire."""

    code = "recording-not-confirmed"


class TapeFullError(RecordingNotConfirmedError):
    """The tape has no room for another shot, and nobody has agreed to erase it."""

    code = "tape-full"


class FramesError(RigError):
    """Frames are missing, damaged, or not of the expected size, depth or count."""

    code = "frames"


class RefusedError(RigError):
    """The rig refuses: wrong state, tripped interlock, or an arm token that does not hold."""

    code = "refused"


class InterlockError(RefusedError):
    """One or more interlocks refuse; all of them are named, one sentence each in `tripped`."""

    code = "interlock"

    def __init__(
        self,
        what: str,
        *,
        tripped: tuple[str, ...] = (),
        todo: str | None = None,
        shot: str | None = None,
    ) -> None:
        self.tripped = tripped
        super().__init__(what, todo=todo, shot=shot)


class ArmTokenError(RefusedError):
    """The arm token is unknown, spent, expired, or bound to other settings."""

    code = "arm-token"


class IdempotencyError(RefusedError):
    """An idempotency key is absent, still running, or was used with another body."""

    code = "idempotency"


class KeyRunningError(IdempotencyError):
    """The shot of this idempotency key has not ended; `shot` names it."""

    code = "idempotency-running"


class KeyReusedError(IdempotencyError):
    """The idempotency key was used with another body."""

    code = "idempotency-reused"


class JobsFullError(RefusedError):
    """So many jobs wait already that no further one is taken."""

    code = "jobs-full"


class StreamsFullError(RigError):
    """So many clients listen to events that no further one is taken."""

    code = "too-many-streams"


class NotFoundError(RigError):
    """Nothing of that name is stored."""

    code = "not-found"


class StoreError(RigError):
    """The store could not write or read what it must."""

    code = "store"


class CatalogueLostError(StoreError):
    """The catalogue is missing, empty, older than the shots beside it, or without its key."""

    code = "catalogue-lost"


class AnalysisInputError(RigError):
    """Files handed to the analysis are absent, damaged or of another form."""

    code = "analysis-input"
