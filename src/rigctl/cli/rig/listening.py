"""Where the daemon listens, and that nobody listens in."""

from __future__ import annotations

import ipaddress
import socket
import ssl

from rigctl.config.configuration import ServiceSection
from rigctl.errors import ConfigurationError

STOP_PORT_ABOVE = 1000
"""The stop's own port lies so far above the service's, unless it is set or taken."""


def listen(section: ServiceSection, port: int | None) -> socket.socket:
    """Return the socket of the service; `port` replaces that of the configuration.

    Raises
    ------
    ConfigurationError
        The port is taken, the certificate is of no use, or the rig would be open to the network
        without encryption.
    """
    host = section.host
    if not (_is_loopback(host) or section.encrypts or section.proxy):
        raise ConfigurationError(
            "keys and orders would cross the network for everybody to read",
            part="service.host",
            value=repr(host),
            limit="a loopback address, or an encrypted connection",
            todo="set service.tls_certificate and service.tls_key, or name in service.proxy the "
            "reverse proxy that encrypts, or listen on 127.0.0.1",
        )
    _require_certificate(section)
    chosen = section.port if port is None else port
    return _bound(host, chosen, "service.port", "choose another with --port, 0 for any free one")


def listen_for_stops(section: ServiceSection, listening: socket.socket) -> socket.socket:
    """Listen on the stop's own port: the one that is set, 1000 above the service's, or any.

    Raises
    ------
    ConfigurationError
        The port that is set is taken.
    """
    if section.stop_port is not None:
        todo = "choose another stop_port, 0 for any free one"
        return _bound(section.host, section.stop_port, "service.stop_port", todo)
    beside = int(listening.getsockname()[1]) + STOP_PORT_ABOVE
    try:
        return _bound(section.host, beside if beside <= 65535 else 0, "service.stop_port", "")
    except ConfigurationError:
        return _bound(section.host, 0, "service.stop_port", "set stop_port")


def _bound(host: str, port: int, part: str, todo: str) -> socket.socket:
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        return socket.create_server((host, port), family=family)
    except OSError as error:
        raise ConfigurationError(
            f"cannot listen there: {error.strerror or error}",
            part=part,
            value=f"{host}:{port}",
            todo=todo,
        ) from error


def url_of(listening: socket.socket, *, encrypts: bool) -> str:
    """Return the address of a socket, as in `http://127.0.0.1:8486`."""
    host, port = listening.getsockname()[:2]
    scheme = "https" if encrypts else "http"
    return f"{scheme}://[{host}]:{port}" if ":" in host else f"{scheme}://{host}:{port}"


def _require_certificate(section: ServiceSection) -> None:
    if section.tls_certificate is None:
        return
    try:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(section.tls_certificate, section.tls_key)
    except OSError as error:
        raise ConfigurationError(
            f"certificate and key cannot be used: {error.strerror or error}",
            part="service.tls_certificate",
            value=f"{section.tls_certificate} with {section.tls_key}",
            todo="name PEM files that belong together and that the daemon may read",
        ) from error


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
