"""A key does what its scopes say, by one table that knows every route."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from rigctl.access.named_keys import KeyFile, NamedKey, hashed
from rigctl.access.scopes import ROUTES, Scope, needed
from rigctl.errors import NotFoundError, SettingsError
from rigctl.store import Store
from rigctl.store.integrity.seal import read_secret

SETTINGS = {"pressure_a_kpa": 40, "pressure_b_kpa": 40, "offset_mm": 6}
CHANGING = {
    Scope.OPERATE: [("POST", "/rig/arm"), ("POST", "/rig/release"), ("POST", "/shots")],
    Scope.SWEEP: [("POST", "/sweeps"), ("POST", "/sweeps/20260131-s0001/abort")],
    Scope.MAINTAIN: [
        ("POST", "/shots/20260131-000001/exclude"),
        ("PUT", "/campaigns/nylon/tags"),
        ("POST", "/campaigns/nylon/reanalyse"),
        ("DELETE", "/jobs/1"),
    ],
}
LOOKING = ["/rig", "/shots", "/campaigns", "/effects", "/jobs"]
NOT_LET = 403


def add(store: Store, name: str, *scopes: Scope, expires_at: datetime | None = None) -> str:
    key = f"the-key-of-{name}-and-nobody-else"
    secret = read_secret(store.path)
    assert secret is not None
    at = None if expires_at is None else expires_at.isoformat()
    KeyFile(store.path).add(NamedKey(name, scopes, hashed(key, secret), "2026-01-31", at))
    return key


def test_every_route_has_a_scope_and_every_scope_a_route(app: Any) -> None:
    documented = {
        (method.upper(), path.removeprefix("/api/v1"))
        for path, operations in app.openapi()["paths"].items()
        for method in operations
        if path.startswith("/api/v1/") and path != "/api/v1/rig/estop"
    }
    assert set(ROUTES) == documented
    # Whatever is no GET and works out no question changes something.
    asking = ("explain", "next", "propose")
    for (method, path), scope in ROUTES.items():
        reads = method == "GET" or path.endswith(asking)
        assert (scope is Scope.READ) == reads, (method, path)


@pytest.mark.parametrize("held", list(Scope))
def test_a_key_does_what_its_scope_says_and_nothing_else(
    ask: Any, store: Store, held: Scope
) -> None:
    key = add(store, "anna", held)
    for path in LOOKING:
        assert ask("GET", f"/api/v1{path}", key=key).status_code == 200
    for scope, routes in CHANGING.items():
        for method, path in routes:
            answer = ask(method, f"/api/v1{path}", key=key)
            let = held in {scope, Scope.ADMIN}
            assert (answer.status_code != NOT_LET) == let, (method, path, answer.text)
            if not let:
                problem = answer.json()
                assert (problem["code"], problem["limit"]) == ("scope-missing", str(scope))
                assert f"needs the scope {scope}" in problem["detail"]


def test_a_path_with_tricks_in_it_needs_no_less_than_the_plain_one() -> None:
    assert needed("POST", "/api/v1/shots") is Scope.OPERATE
    assert needed("PUT", "/api/v1/shots/x y/note") is Scope.MAINTAIN
    assert needed("HEAD", "/api/v1/shots") is Scope.READ
    assert needed("POST", "/api/v1/nothing-there") is Scope.READ


def test_the_audit_knows_the_holder_by_name(ask: Any, rig: Any, store: Store) -> None:
    key = add(store, "anna", Scope.OPERATE)
    ask("POST", "/api/v1/rig/arm", key=key, json=SETTINGS)
    ((_, actor),) = rig.armed
    assert actor.startswith("anna at ")
    ask("POST", "/api/v1/rig/estop", key=key)
    assert rig.stops[0][0].startswith("anna at ")


def test_a_revoked_key_opens_nothing_from_the_next_request_on(ask: Any, store: Store) -> None:
    key = add(store, "anna", Scope.ADMIN)
    assert ask("GET", "/api/v1/rig", key=key).status_code == 200
    KeyFile(store.path).revoke("anna", datetime.now(UTC))
    answer = ask("GET", "/api/v1/rig", key=key)
    assert answer.status_code == 401
    assert "'anna' was revoked" in answer.json()["detail"]
    with pytest.raises(SettingsError, match="a key of this name"):
        add(store, "anna", Scope.READ)
    with pytest.raises(NotFoundError, match="no such key"):
        KeyFile(store.path).revoke("ben", datetime.now(UTC))


def test_an_expired_key_opens_nothing(ask: Any, store: Store) -> None:
    now = datetime.now(UTC)
    late = add(store, "late", Scope.READ, expires_at=now - timedelta(seconds=1))
    good = add(store, "good", Scope.READ, expires_at=now + timedelta(days=1))
    assert "'late' expired" in ask("GET", "/api/v1/rig", key=late).json()["detail"]
    assert ask("GET", "/api/v1/rig", key=good).status_code == 200


@pytest.mark.parametrize("name", ["", "key", "sweep", "two words", "ümlaut", "x" * 33, "1st"])
def test_a_name_that_the_audit_could_take_for_another_is_refused(store: Store, name: str) -> None:
    with pytest.raises(SettingsError, match="is no name of a key"):
        add(store, name, Scope.READ)


def test_the_file_of_keys_holds_no_key_and_is_its_owners_alone(store: Store) -> None:
    key = add(store, "anna", Scope.READ)
    path = store.path / "keys.json"
    assert key not in path.read_text()
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_damaged_file_of_keys_shuts_named_keys_out_and_not_the_daemons(
    ask: Any, store: Store
) -> None:
    key = add(store, "anna", Scope.ADMIN)
    (store.path / "keys.json").write_text("{")
    assert ask("GET", "/api/v1/rig", key=key).status_code == 401
    assert ask("GET", "/api/v1/rig").status_code == 200
