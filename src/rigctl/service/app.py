"""The REST application: routes, problems, key and events around one daemon."""

from __future__ import annotations

import logging
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.metadata import version

from fastapi import Depends, FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.routing import iter_route_contexts
from starlette.exceptions import HTTPException
from starlette.responses import Response

from rigctl.access.keyring import Keyring
from rigctl.access.wrong_keys import MANY, WITHIN_S, WrongKeys
from rigctl.config import Limits
from rigctl.daemon import Daemon
from rigctl.errors import RigError
from rigctl.service.events import EventHub
from rigctl.service.guards.auth import PREFIX, KeyGuard
from rigctl.service.guards.body_limit import BodyLimit
from rigctl.service.guards.requests import require_known
from rigctl.service.job_models import JobSummary
from rigctl.service.lanes import Lanes
from rigctl.service.metrics import Metrics, metrics_route
from rigctl.service.models import RigEvent, ShotView
from rigctl.service.openapi import describe, openapi_route
from rigctl.service.problems import Problem, answer, from_error, from_validation, unforeseen
from rigctl.service.routes.campaigns import campaign_routes
from rigctl.service.routes.commissioning import commissioning_routes
from rigctl.service.routes.edits import campaign_edit_routes, edit_routes
from rigctl.service.routes.effects import effect_routes
from rigctl.service.routes.events import event_routes
from rigctl.service.routes.film import film_routes
from rigctl.service.routes.front import front_route
from rigctl.service.routes.health import health_routes
from rigctl.service.routes.jobs import job_routes
from rigctl.service.routes.model import model_routes
from rigctl.service.routes.recorder import recorder_routes
from rigctl.service.routes.report import report_routes
from rigctl.service.routes.rig import rig_routes
from rigctl.service.routes.shots import shot_routes
from rigctl.service.routes.sweeps import sweep_routes
from rigctl.service.sweep_models import SweepView

_log = logging.getLogger(__name__)

_FRAMEWORK = {
    404: ("no-such-route", "There is no such path", "look at /openapi.json"),
    405: ("method-not-allowed", "The path knows no such method", "use a method named in Allow"),
}
_OTHERWISE = ("bad-request", "The request cannot be answered", "correct the request")


def create_app(daemon: Daemon, key: str, hub: EventHub) -> FastAPI:
    """Return the application that answers for a daemon to holders of `key`, or of a named one.

    Changes of rig and store go to `hub` for as long as the application runs; the code that ends the
    server closes the hub first, so that listening clients are released.
    """
    metrics = Metrics(daemon, hub)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        deaf = [
            daemon.rig.listeners.add(lambda step: hub.publish("rig", RigEvent.of(step))),
            daemon.store.listeners.add(lambda record: hub.publish("shot", ShotView.of(record))),
            daemon.jobs.listeners.add(lambda job: hub.publish("job", JobSummary.of(job))),
            daemon.sweeps.listeners.add(lambda now: hub.publish("sweep", SweepView.of(now))),
            *metrics.listen(daemon),
        ]
        try:
            yield
        finally:
            for stop_listening in deaf:
                stop_listening()
            hub.close()

    app = FastAPI(
        title="rigctl",
        version=version("rigctl"),
        description="Fires the rig, films two spheres, measures the impact.",
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
        redirect_slashes=False,
        lifespan=lifespan,
        dependencies=[Depends(require_known)],
    )
    lanes = Lanes()
    app.state.lanes = lanes
    app.state.keyring = Keyring(key, lambda: daemon.store.path)
    app.state.wrong_keys = WrongKeys(lambda address: _log_wrong_keys(daemon, address))
    app.include_router(rig_routes(daemon, lanes), prefix=PREFIX)
    app.include_router(commissioning_routes(daemon, lanes), prefix=PREFIX)
    app.include_router(recorder_routes(daemon, lanes), prefix=PREFIX)
    app.include_router(film_routes(daemon), prefix=PREFIX)
    app.include_router(shot_routes(daemon, lanes), prefix=PREFIX)
    app.include_router(edit_routes(daemon), prefix=PREFIX)
    app.include_router(sweep_routes(daemon, lanes), prefix=PREFIX)
    app.include_router(campaign_routes(daemon), prefix=PREFIX)
    app.include_router(campaign_edit_routes(daemon), prefix=PREFIX)
    app.include_router(model_routes(daemon), prefix=PREFIX)
    app.include_router(report_routes(daemon), prefix=PREFIX)
    app.include_router(effect_routes(daemon), prefix=PREFIX)
    app.include_router(job_routes(daemon), prefix=PREFIX)
    app.include_router(event_routes(daemon, hub), prefix=PREFIX)
    app.include_router(health_routes(daemon, app.state.wrong_keys))
    app.include_router(metrics_route(metrics))
    app.include_router(front_route(daemon))
    _answer_errors_as_problems(app, daemon.configuration.limits)
    app.openapi = describe(app, daemon.configuration.limits)  # type: ignore[method-assign]
    app.include_router(openapi_route(app))
    app.add_middleware(BodyLimit)
    app.add_middleware(KeyGuard, keyring=app.state.keyring, wrong=app.state.wrong_keys)
    return app


def _log_wrong_keys(daemon: Daemon, address: str) -> None:
    """Log the address of many wrong keys, in a thread of its own."""
    _log.warning("%d wrong keys within %g s from %s", MANY, WITHIN_S, address)

    def note() -> None:
        try:
            daemon.store.edits.wrong_keys(address, f"{MANY} within {WITHIN_S:g} s")
        except RigError as error:
            _log.warning("not in the audit: wrong keys from %s: %s", address, error)

    threading.Thread(target=note, name="wrong keys", daemon=True).start()


def _answer_errors_as_problems(app: FastAPI, limits: Limits) -> None:
    @app.exception_handler(RigError)
    async def rig_error(_: Request, error: RigError) -> Response:
        return answer(from_error(error))

    @app.exception_handler(RequestValidationError)
    async def bad_request(_: Request, error: RequestValidationError) -> Response:
        return answer(from_validation(error, limits))

    @app.exception_handler(HTTPException)
    async def framework_error(request: Request, error: HTTPException) -> Response:
        headers = dict(error.headers or {})
        if error.status_code == 405:
            headers["Allow"] = ", ".join(_allowed(app, request.url.path))
        return answer(_of_framework(request, error), headers)

    @app.exception_handler(Exception)
    async def failure(_: Request, error: Exception) -> Response:
        return answer(unforeseen(error, todo="look at the daemon's log and report it"))


def _of_framework(request: Request, error: HTTPException) -> Problem:
    if error.status_code == 400:
        # The framework's one 400: a body that is no text. One that is no JSON gives 422 as well.
        return Problem(
            status=422,
            code="invalid-request",
            title="The request cannot be understood",
            detail="body: is not JSON in UTF-8",
            field="body",
            todo="correct the body and send the request again",
        )
    code, title, todo = _FRAMEWORK.get(error.status_code, _OTHERWISE)
    return Problem(
        status=error.status_code,
        code=code,
        title=title,
        detail=f"{request.method} {request.url.path}: {title[0].lower()}{title[1:]}",
        todo=todo,
    )


def _allowed(app: FastAPI, path: str) -> list[str]:
    """Return all methods of a path; the framework names those of one route only."""
    methods: set[str] = set()
    for route in iter_route_contexts(app.routes):
        if route.methods and route.path_regex.fullmatch(path):
            methods |= route.methods
    return sorted(methods)
