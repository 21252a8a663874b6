"""The REST service as commands, the Bluesky devices and scripts call it."""

from __future__ import annotations

import ssl
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Self
from urllib.parse import quote

import httpx

from rigctl.access.strength import Chosen
from rigctl.config import load
from rigctl.errors import ConfigurationError, RefusedError, RigError, SettingsError
from rigctl.rig.arming import Armed
from rigctl.service import keyfile
from rigctl.service.keyfile import ServiceAddress
from rigctl.settings import ShotSettings

_ANSWER_TIMEOUT_S = 10.0
# Arming waits for pressure and slide; the configuration bounds their settling to an hour at most.
_ARM_TIMEOUT_S = 120.0
_FILM_TIMEOUT_S = 900.0
_POLL_S = 0.2


@contextmanager
def connected(path: Path | None, key: Chosen | None) -> Iterator[ServiceClient]:
    """Give a client of the daemon that runs on a configuration's store.

    Its address and key are those that the daemon wrote beside its store; a key given here is used
    in the place of the written one.

    Raises
    ------
    ConfigurationError
        The configuration cannot be, or no daemon wrote its key and none is given.
    """
    configuration = load(path)
    try:
        address = keyfile.read(Path(configuration.store.folder))
    except ConfigurationError:
        if key is None:
            raise
        service = configuration.service
        scheme = "https" if service.encrypts else "http"
        url = f"{scheme}://{service.host}:{service.port}"
        address = ServiceAddress(url, key.key, service.tls_certificate)
    with ServiceClient(address if key is None else replace(address, key=key.key)) as client:
        yield client


class ServiceClient:
    """REST client of a running daemon; a problem document is raised as the error it was made from.

    Nothing is ever sent twice: a lost answer to a fire is reported, and the shot's fate is read
    from the list of shots.
    """

    def __init__(
        self, address: ServiceAddress, transport: httpx.BaseTransport | None = None
    ) -> None:
        self._url = address.url
        self._http = httpx.Client(
            base_url=f"{address.url}/api/v1",
            headers={"Authorization": f"Bearer {address.key}"},
            transport=transport,
            trust_env=False,
            # Without encryption nothing is checked: reading all certificates takes 20 ms.
            verify=address.url.startswith("https") and _trusting(address.certificate),
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._http.close()

    def arm(self, settings: ShotSettings) -> Armed:
        """Set the rig, wait until it has settled, and return token and warnings."""
        body = settings.model_dump(exclude_none=True)
        found = self._ask("POST", "/rig/arm", body, timeout_s=_ARM_TIMEOUT_S)
        return Armed(
            str(found["arm_token"]),
            datetime.fromisoformat(found["expires_at"]),
            float(found["expires_in_s"]),
            tuple(found["warnings"]),
        )

    def release(self, reason: str) -> dict[str, Any]:
        """Let the rig leave its latch and return its state."""
        return self._ask("POST", "/rig/release", {"reason": reason})

    def commissioning(self) -> dict[str, Any]:
        """Return the steps of the commissioning as they stand."""
        return self._ask("GET", "/rig/commissioning")

    def commissioning_record(self) -> dict[str, Any]:
        """Return the signed record of the commissioning."""
        return self._ask("GET", "/rig/commissioning/record")

    def do_step(self, step: str) -> dict[str, Any]:
        """Have the daemon do its part of a step; return what it saw."""
        path = f"/rig/commissioning/{step}/act"
        # A shot of it may wait for a film that is brought by hand.
        return self._ask("POST", path, timeout_s=_FILM_TIMEOUT_S)

    def answer_step(
        self, step: str, people: Sequence[str], note: str | None, *, seen: bool
    ) -> dict[str, Any]:
        """Say whether a step was as it must be; return how it stands."""
        body = {"seen": seen, "people": list(people), "note": note}
        return self._ask("POST", f"/rig/commissioning/{step}/answer", body)

    def rewired(self, part: str, people: Sequence[str], note: str) -> dict[str, Any]:
        """Ask for the steps of a part again; return all as they stand."""
        body = {"part": part, "people": list(people), "note": note}
        return self._ask("POST", "/rig/commissioning/rewired", body)

    def recorder(self) -> dict[str, Any]:
        """Return what the tape recorder does and what is on its tape."""
        return self._ask("GET", "/rig/recorder")

    def press(self, order: Mapping[str, Any]) -> dict[str, Any]:
        """Press a key of the tape recorder; return how it stands then."""
        return self._ask("POST", "/rig/recorder", order)

    def film(self) -> dict[str, Any]:
        """Return what the shot under way waits for of a camera that people work."""
        return self._ask("GET", "/rig/film")

    def film_word(self, says: str) -> dict[str, Any]:
        """Say `records` or `gives-up` of it."""
        return self._ask("POST", "/rig/film", {"says": says})

    def bring_film(self, path: Path) -> dict[str, Any]:
        """Bring a film; return the job that reads it, once that has ended."""
        headers = {"Content-Length": str(path.stat().st_size)}
        with path.open("rb") as film:
            job = self._ask(
                "PUT", f"/rig/film/{quote(path.name)}", film, headers, timeout_s=_FILM_TIMEOUT_S
            )
        while job["ended_at"] is None:
            time.sleep(_POLL_S)
            job = self._ask("GET", f"/jobs/{job['job']}")
        return job

    def fire(self, token: str, key: str, campaign: str | None) -> str:
        """Fire once under this idempotency key and return the shot's id."""
        body = {"arm_token": token} | ({"campaign": campaign} if campaign else {})
        answer = self._ask("POST", "/shots", body, headers={"Idempotency-Key": key})
        return str(answer["shot"])

    def shot(self, shot: str) -> dict[str, Any]:
        """Return one shot as the service lists it."""
        return self._ask("GET", f"/shots/{shot}")

    def result(self, shot: str) -> dict[str, Any]:
        """Return the measurement of one shot."""
        return self._ask("GET", f"/shots/{shot}/result")

    def start_sweep(self, form: Mapping[str, Any], key: str) -> dict[str, Any]:
        """Start a sweep under this idempotency key and return it."""
        return self._ask("POST", "/sweeps", form, headers={"Idempotency-Key": key})

    def sweeps(self) -> dict[str, Any]:
        """Return the list of sweeps, latest first."""
        return self._ask("GET", "/sweeps")

    def sweep(self, name: str) -> dict[str, Any]:
        """Return one sweep as the service lists it."""
        return self._ask("GET", f"/sweeps/{name}")

    def sweep_steps(self, name: str) -> dict[str, Any]:
        """Return the request of a sweep (`form`) and its steps (`table`)."""
        return self._ask("GET", f"/sweeps/{name}/steps")

    def order_sweep(self, name: str, wish: str) -> dict[str, Any]:
        """Pause, resume or abort a sweep and return it."""
        return self._ask("POST", f"/sweeps/{name}/{wish}")

    def _ask(
        self,
        method: str,
        path: str,
        body: Mapping[str, Any] | BinaryIO | None = None,
        headers: Mapping[str, str] | None = None,
        timeout_s: float = _ANSWER_TIMEOUT_S,
    ) -> dict[str, Any]:
        sent = {"json": body} if body is None or isinstance(body, Mapping) else {"content": body}
        try:
            answer = self._http.request(method, path, headers=headers, timeout=timeout_s, **sent)
        except httpx.ConnectError as error:
            raise ConfigurationError(
                "no daemon answers there",
                part=self._url,
                todo="start one with `rigctl serve`, or fire with --local",
            ) from error
        except httpx.TransportError as error:
            raise RigError(
                f"the daemon's answer to {method} {path} was lost ({type(error).__name__})",
                part=self._url,
                todo="look at GET /api/v1/shots before anything is fired again",
            ) from error
        if answer.is_success:
            return dict(answer.json())
        raise error_of(answer)


def _trusting(certificate: str | None) -> ssl.SSLContext | bool:
    """Return whom to trust: a daemon on this host shows the certificate of its configuration."""
    if certificate is None:
        return True
    context = ssl.create_default_context()
    context.load_verify_locations(certificate)
    return context


def error_of(answer: httpx.Response) -> RigError:
    """Return the error that a problem document was made from."""
    try:
        document = dict(answer.json())
    except ValueError:
        document = {}
    detail = str(document.get("detail", f"HTTP {answer.status_code}"))
    kinds = {kind.code: kind for kind in _tree(RigError)}
    kind = kinds.get(str(document.get("code")), _by_status(answer.status_code))
    # The detail of an error of ours is a whole sentence, with what to do at its end.
    todo = document.get("todo")
    return kind(detail, todo=None if todo is None or todo in detail else str(todo))


def _tree(kind: type[RigError]) -> Iterator[type[RigError]]:
    yield kind
    for below in kind.__subclasses__():
        yield from _tree(below)


def _by_status(status: int) -> type[RigError]:
    kinds = {
        401: ConfigurationError,
        403: RefusedError,
        409: RefusedError,
        422: SettingsError,
        503: RefusedError,
    }
    return kinds.get(status, RigError)
