from __future__ import annotations

from collections.abc import Iterator

import pytest
import serial

from simulators.wire import protocol_sim


class Bench:
    def __init__(self) -> None:
        self.edges: list[bool] = []
        self.url = protocol_sim.publish("test/contact", self.edges.append)

    def port(self) -> serial.SerialBase:
        """Return the port closed, with its lines preset low."""
        port = serial.serial_for_url(self.url, do_not_open=True, exclusive=True, timeout=0.0)
        port.dtr = port.rts = False
        return port


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    protocol_sim.withdraw(bench.url)


def test_opening_raises_rts_for_a_moment_although_it_is_preset_low(bench: Bench) -> None:
    with bench.port() as port:
        assert port.is_open
        assert bench.edges == [True, False]


def test_rts_follows_the_host_and_drops_on_closing(bench: Bench) -> None:
    port = bench.port()
    port.open()
    del bench.edges[:]
    port.rts = True
    port.rts = False
    port.rts = True
    port.close()
    port.close()
    assert bench.edges == [True, False, True, False]


def test_a_second_host_is_refused_while_the_first_holds_the_port(bench: Bench) -> None:
    with bench.port(), pytest.raises(serial.SerialException, match="lock"):
        bench.port().open()
    bench.port().open()


def test_a_port_that_was_taken_away_cannot_be_opened_or_driven(bench: Bench) -> None:
    with bench.port() as port:
        protocol_sim.withdraw(bench.url)
        with pytest.raises(serial.SerialException, match="gone"):
            port.rts = True
    with pytest.raises(serial.SerialException, match="could not open"):
        bench.port().open()


def test_no_byte_ever_comes(bench: Bench) -> None:
    with bench.port() as port:
        assert port.write(b"hello") == 5
        assert (port.in_waiting, port.read(1)) == (0, b"")
