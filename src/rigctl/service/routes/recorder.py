"""The tape recorder's keypad over REST."""

from __future__ import annotations

from typing import Literal, Self

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, Field, model_validator

from rigctl.cameras.keypad import Keypad
from rigctl.config.model import StrictModel
from rigctl.daemon import Daemon
from rigctl.devices.ektapro import RecorderMode, TapePlace
from rigctl.errors import NotFoundError
from rigctl.rig.tape import erase_tape
from rigctl.service.forms import View
from rigctl.service.guards.requests import StrictRoute
from rigctl.service.lanes import Lanes
from rigctl.service.pictures import png
from rigctl.service.problems import documented

Key = Literal[
    "live", "record", "stop", "replay", "play", "jog", "step", "search", "gamma", "erase",
    "when-full",
]  # fmt: skip
"""What can be pressed; `when-full` says whether a shot may erase a tape without room."""
_NEEDED = {"jog": "speed", "step": "by", "gamma": "gamma", "when-full": "erase"}
_SEARCHED = ("session", "mark", "frame", "time_s")


class KeyOrder(StrictModel):
    """One key of the recorder, with what belongs to it and nothing else."""

    key: Key
    speed: int | None = Field(
        default=None, ge=-30, le=30, description="jog: pictures a second, negative backwards"
    )
    by: Literal[-1, 1] | None = Field(default=None, description="step: forward or back")
    session: int | None = Field(default=None, ge=1, le=999_999_999)
    mark: int | None = Field(default=None, ge=1, le=999_999_999, description="counted from 1")
    frame: int | None = Field(default=None, ge=0, le=999_999_999, description="counted from 0")
    time_s: float | None = Field(default=None, ge=0, le=1e5, description="from its first picture")
    gamma: float | None = Field(default=None, ge=0.1, le=1.0)
    erase: bool | None = Field(default=None, description="when-full: agreed or not")

    @model_validator(mode="after")
    def _has_what_it_needs_alone(self) -> Self:
        given = self.model_dump(exclude={"key"}, exclude_none=True)
        own = set(_SEARCHED) if self.key == "search" else {_NEEDED.get(self.key, "")}
        if extra := sorted(set(given) - own):
            raise ValueError(f"{self.key} takes no {', '.join(extra)}")
        if not given and self.key in {"search", *_NEEDED}:
            raise ValueError(f"{self.key} needs {' or '.join(sorted(own))}")
        return self

    def press(self, keypad: Keypad) -> None:
        """Press the key; an erasure has more to it, and is not pressed here."""
        if self.key == "jog" and self.speed is not None:
            keypad.jog(self.speed)
        elif self.key == "step" and self.by is not None:
            keypad.step(self.by)
        elif self.key == "gamma" and self.gamma is not None:
            keypad.gamma(self.gamma)
        elif self.key == "when-full":
            keypad.agree(erases_when_full=bool(self.erase))
        elif self.key == "search":
            keypad.search(
                session=self.session, mark=self.mark, frame=self.frame, time_s=self.time_s
            )
        else:
            plain = {
                "live": keypad.live, "record": keypad.record, "stop": keypad.stop,
                "replay": keypad.replay, "play": keypad.play,
            }  # fmt: skip
            plain[self.key]()


class SessionView(BaseModel):
    """A session on the tape, and how many pictures it holds."""

    session: int
    pictures: int


class RecorderView(View):
    """The recorder and its tape. Times are in seconds; what cannot be said is null."""

    mode: RecorderMode
    session: int
    pictures: int
    picture: int | None
    picture_s: float | None
    marks: list[int]
    sessions: list[SessionView]
    seconds_left: float
    needed_s: float = Field(description="what a shot needs of the tape")
    place: TapePlace
    gamma: float | None
    erases_when_full: bool

    @classmethod
    def of(cls, keypad: Keypad) -> Self:
        """Ask the recorder and return what it says."""
        status = keypad.status()
        sessions = [SessionView(session=k, pictures=n) for k, n in status.sessions.items()]
        return cls.showing(status, marks=list(status.marks), sessions=sessions)


def recorder_routes(daemon: Daemon, lanes: Lanes) -> APIRouter:
    """Return the routes below `/rig/recorder`."""
    router = APIRouter(prefix="/rig/recorder", tags=["rig"], route_class=StrictRoute)

    @router.get("", responses=documented(401, 404, 405, 409, 503))
    async def status() -> RecorderView:
        """Show mode, tape, session, picture and marks; refused while a shot is under way."""
        keypad = require_keypad(daemon)
        return await lanes.control(lambda: RecorderView.of(keypad))

    @router.post("", responses=documented(401, 404, 405, 409, 411, 413, 422, 503))
    async def press(order: KeyOrder, request: Request) -> RecorderView:
        """Press one key; refused while a shot is under way. The audit records what is erased."""
        keypad, who = require_keypad(daemon), request.state.actor
        await lanes.control(lambda: pressed(daemon, keypad, order, who))
        return await lanes.control(lambda: RecorderView.of(keypad))

    @router.get(
        "/picture.png",
        response_class=Response,
        responses={
            200: {"content": {"image/png": {"schema": {"type": "string", "format": "binary"}}}},
            **documented(401, 404, 405, 409, 500, 503),
        },
    )
    async def picture() -> Response:
        """Stop playback and show the picture on which it stands, as PNG."""
        keypad = require_keypad(daemon)
        frames = await lanes.control(keypad.still)
        return Response(png(frames.pixels[0]), media_type="image/png")

    return router


def require_keypad(daemon: Daemon) -> Keypad:
    """Return the keypad of the rig's recorder; raise `NotFoundError` where it has none."""
    if daemon.keypad is None:
        raise NotFoundError(
            "this rig's camera is no tape recorder", part="camera", todo="use the camera's own page"
        )
    return daemon.keypad


def pressed(daemon: Daemon, keypad: Keypad, order: KeyOrder, actor: str) -> None:
    """Press a key; the audit records what it has erased."""
    if order.key == "erase":
        erase_tape(keypad, daemon.store, actor)
    else:
        order.press(keypad)
