from __future__ import annotations

from typing import Protocol

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulators.ektapro.link import Link
from simulators.ektapro.processor import Processor, Transfer


class Clock(Protocol):
    now: float

    def __call__(self) -> float: ...
    def advance(self, seconds: float) -> None: ...


class Bench:
    """A recorder with a run-up of 0.2 s, its link, and the transfers it was asked for."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.processor = Processor(clock, run_up_s=0.2)
        self.transfers: list[Transfer] = []
        self._link = Link(self.processor, self._take)

    def _take(self, transfer: Transfer) -> None:
        if any(transfer.name == other.name for other in self.transfers):
            raise ValueError(f"{transfer.name} exists")
        self.transfers.append(transfer)

    def ask(self, line: str, after_s: float = 0.0) -> str:
        self.clock.advance(after_s)
        answer = self._link.answer(line.encode())
        assert answer.endswith(b"\n")
        assert answer.count(b"\n") == 1
        return answer.decode().rstrip("\n")

    def mode(self) -> str:
        return self.ask("STATUS?").split()[1]

    def recorded(self, pictures: int = 1000) -> Bench:
        """Return the bench with a stopped session of so many pictures at 1000/s."""
        self.ask("RECORD")
        self.ask("STOP", after_s=0.2 + (pictures - 0.5) / 1000)
        return self


@pytest.fixture
def bench(clock: Clock) -> Bench:
    return Bench(clock)


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        (["ID?"], "OK EKTAPRO-SIM 2"),
        (["STATUS?"], "OK LIVE 0 0 30.000 BOT"),
        (["RATE 30 1"], "OK 30 192"),
        (["RATE 1000 6"], "OK 6000 32"),
        (["RATE 999 1"], "ERR RANGE rate is one of (30, 60, 125, 250, 500, 1000)"),
        (["RATE 1000 5"], "ERR RANGE pictures per frame is one of (1, 2, 3, 4, 6)"),
        (["LIVE"], "OK LIVE"),
        (["STOP"], "OK STOP"),
        (["RECORD"], "OK RECORD 1"),
        (["RECORD", "RECORD"], "ERR MODE RECORD not in STARTING"),
        (["RECORD", "RATE 30 1"], "ERR MODE RATE not in STARTING"),
        (["RECORD", "STOP", "RECORD"], "OK RECORD 2"),
        (["RECORD", "STOP", "REPLAY"], "ERR EMPTY no pictures"),
        (["MARK"], "ERR MODE MARK not in LIVE"),
        (["MARKS?"], "OK"),
        (["SESSIONS?"], "OK"),
        (["SESSION 1"], "ERR RANGE sessions 1 to 0"),
        (["REPLAY"], "ERR EMPTY no pictures"),
        (["PLAY"], "ERR EMPTY no pictures"),
        (["PICTURE?"], "ERR EMPTY no pictures"),
        (["STEP +1"], "ERR EMPTY no pictures"),
        (["SEARCH 0"], "ERR EMPTY no pictures"),
        (["JOG +5"], "ERR EMPTY no pictures"),
        (["TRANSFER 0 1 shot"], "ERR EMPTY no session"),
        (["ERASE"], "OK BOT"),
        (["STEP +2"], "ERR SYNTAX unknown command"),
        (["RATE 1000"], "ERR SYNTAX unknown command"),
        (["record"], "ERR SYNTAX unknown command"),
        ([""], "ERR SYNTAX unknown command"),
    ],
)
def test_a_recorder_that_was_switched_on_answers_as_the_page_says(
    bench: Bench, asked: list[str], answered: str
) -> None:
    assert [bench.ask(each) for each in asked][-1] == answered


@pytest.mark.parametrize(
    ("asked", "answered"),
    [
        (["STATUS?"], "OK STOP 1 1000 29.000 MID"),
        (["SESSIONS?"], "OK 1:1000"),
        (["PICTURE?"], "OK PICTURE 999"),
        (["STEP -1"], "OK PICTURE 998"),
        (["STEP +1"], "ERR RANGE pictures 0 to 999"),
        (["SESSION 1", "PICTURE?"], "OK PICTURE 0"),
        (["SESSION 1", "STEP -1"], "ERR RANGE pictures 0 to 999"),
        (["SESSION 2"], "ERR RANGE sessions 1 to 1"),
        (["SEARCH 500"], "OK PICTURE 500"),
        (["SEARCH 1000"], "ERR RANGE pictures 0 to 999"),
        (["JOG +31"], "ERR RANGE 1 to 30 pictures a second"),
        (["JOG +0"], "ERR RANGE 1 to 30 pictures a second"),
        (["TRANSFER 0 1000 shot-1"], "OK TRANSFER 1000 shot-1"),
        (["TRANSFER 1 1000 shot-1"], "ERR RANGE session holds 1000 pictures"),
        (["TRANSFER 0 0 shot-1"], "ERR RANGE session holds 1000 pictures"),
        (["TRANSFER 0 1 ../shot"], "ERR SYNTAX unknown command"),
        (["TRANSFER 0 1 a", "TRANSFER 5 1 a"], "ERR NAME a exists"),
        (["REPLAY", "TRANSFER 0 1 a"], "ERR MODE TRANSFER not in REPLAY"),
        (["REPLAY", "ERASE"], "ERR MODE ERASE not in REPLAY"),
        (["ERASE", "STATUS?"], "OK STOP 0 0 30.000 BOT"),
        (["ERASE", "RECORD"], "OK RECORD 1"),
    ],
)
def test_a_recorder_with_one_session_answers_as_the_page_says(
    bench: Bench, asked: list[str], answered: str
) -> None:
    bench.recorded(1000)
    assert [bench.ask(each) for each in asked][-1] == answered


def test_nothing_is_recorded_before_the_tape_has_run_up(bench: Bench) -> None:
    bench.ask("RECORD")
    assert bench.ask("STATUS?", after_s=0.199) == "OK STARTING 1 0 30.000 MID"
    assert bench.ask("MARK") == "ERR MODE MARK not in STARTING"
    assert bench.ask("STATUS?", after_s=0.0015) == "OK RECORD 1 1 29.999 MID"


def test_pictures_from_before_the_command_cannot_be_had(bench: Bench) -> None:
    told_at = bench.clock.now
    bench.recorded(1000).ask("TRANSFER 0 1000 shot")
    (transfer,) = bench.transfers
    assert transfer.first_s == pytest.approx(told_at + 0.2)
    assert bench.ask("TRANSFER -1 10 early").startswith("ERR")


def test_pictures_not_yet_recorded_cannot_be_had(bench: Bench) -> None:
    bench.recorded(1000)
    bench.clock.advance(10.0)
    assert bench.ask("TRANSFER 1000 1 late") == "ERR RANGE session holds 1000 pictures"
    assert bench.transfers == []


def test_a_mark_names_the_picture_being_recorded(bench: Bench) -> None:
    bench.ask("RECORD")
    assert bench.ask("MARK", after_s=0.2 + 0.0425) == "OK MARK 42"
    assert bench.ask("MARK", after_s=1.0) == "OK MARK 1042"
    bench.ask("STOP")
    assert bench.ask("MARKS?") == "OK 42 1042"


@pytest.mark.parametrize(("rate", "split", "seconds"), [(1000, 1, 30), (1000, 6, 30), (30, 1, 960)])
def test_the_end_of_the_tape_stops_it_by_itself(
    bench: Bench, rate: int, split: int, seconds: int
) -> None:
    bench.ask(f"RATE {rate} {split}")
    bench.ask("RECORD")
    bench.clock.advance(0.2 + seconds - 1.0)
    assert bench.mode() == "RECORD"
    bench.clock.advance(1.1)
    whole = 28_800 if rate == 30 else 30_000 * split
    assert bench.ask("STATUS?") == f"OK STOP 1 {whole} 0.000 EOT"
    assert bench.ask("RECORD") == "ERR EOT tape full, ERASE first"
    assert bench.ask("ERASE") == "OK BOT"
    assert bench.ask("RECORD") == "OK RECORD 1"


def test_the_remote_trigger_records_on_closing_and_stops_on_opening(bench: Bench) -> None:
    bench.processor.contact(True)
    assert bench.mode() == "STARTING"
    bench.clock.advance(0.3)
    bench.processor.contact(True)
    assert bench.mode() == "RECORD"
    bench.processor.contact(False)
    assert bench.mode() == "STOP"
    assert bench.ask("SESSIONS?") == "OK 1:101"
    bench.processor.contact(False)
    bench.processor.contact(True)
    assert bench.ask("STATUS?").startswith("OK STARTING 2 ")


def test_a_closing_edge_on_a_full_tape_is_lost(bench: Bench) -> None:
    bench.recorded(1)
    bench.ask("RECORD")
    bench.clock.advance(100.0)
    bench.processor.contact(True)
    assert bench.ask("STATUS?") == "OK STOP 2 29999 0.000 EOT"


def test_a_contact_that_stays_closed_does_not_record_again(bench: Bench) -> None:
    bench.processor.contact(True)
    bench.ask("STOP", after_s=1.0)
    bench.processor.contact(True)
    assert bench.mode() == "STOP"


def test_replay_runs_at_thirty_pictures_a_second_and_stops_at_the_last(bench: Bench) -> None:
    bench.recorded(61)
    bench.ask("REPLAY")
    assert bench.ask("PICTURE?") == "OK PICTURE 0"
    assert bench.ask("PICTURE?", after_s=1.01) == "OK PICTURE 30"
    assert bench.mode() == "REPLAY"
    assert bench.ask("PICTURE?", after_s=1.0) == "OK PICTURE 60"
    assert bench.mode() == "STOP"


def test_replay_shows_the_latest_session_and_play_goes_on_where_it_stands(bench: Bench) -> None:
    bench.recorded(100).recorded(50)
    bench.ask("SESSION 1")
    bench.ask("SEARCH 40")
    bench.ask("PLAY", after_s=1.0)
    assert bench.ask("PICTURE?", after_s=0.51) == "OK PICTURE 55"
    bench.ask("REPLAY")
    assert bench.ask("STATUS?") == "OK REPLAY 2 50 29.850 MID"


def test_jog_runs_slowly_either_way(bench: Bench) -> None:
    bench.recorded(100)
    bench.ask("JOG -5")
    assert bench.ask("PICTURE?", after_s=2.01) == "OK PICTURE 89"
    bench.ask("JOG +2")
    assert bench.ask("PICTURE?", after_s=1.01) == "OK PICTURE 91"
    bench.ask("STOP")
    assert bench.ask("PICTURE?", after_s=9.0) == "OK PICTURE 91"


def test_search_winds_faster_than_the_highest_recording_speed(bench: Bench) -> None:
    bench.recorded(10_000)
    bench.ask("SEARCH 0")
    assert bench.mode() == "SEARCH"
    bench.clock.advance(10_000 / 6000)
    assert bench.mode() == "STOP"
    assert bench.ask("PICTURE?") == "OK PICTURE 0"


def test_a_recorder_that_never_starts_stays_in_starting(bench: Bench) -> None:
    bench.processor.stick(True)
    bench.ask("RECORD")
    assert bench.ask("STATUS?", after_s=60.0) == "OK STARTING 1 0 30.000 MID"
    bench.processor.stick(False)
    assert bench.ask("STATUS?", after_s=0.5).startswith("OK RECORD 1 ")


RESTING, PLAYING, RECORDING = {"LIVE", "STOP"}, {"REPLAY", "PLAY", "JOG", "SEARCH"}, {"RECORD"}
NOT_RECORDING = RESTING | PLAYING
OBEYED_IN = {
    "RATE 500 2": RESTING,
    "LIVE": NOT_RECORDING | RECORDING | {"STARTING"},
    "RECORD": NOT_RECORDING,
    "STOP": NOT_RECORDING | RECORDING | {"STARTING"},
    "MARK": RECORDING,
    "SESSION 1": NOT_RECORDING,
    "REPLAY": NOT_RECORDING,
    "PLAY": NOT_RECORDING,
    "STEP +1": NOT_RECORDING,
    "JOG -1": NOT_RECORDING,
    "SEARCH 3": NOT_RECORDING,
    "TRANSFER 0 1 shot": RESTING,
    "ERASE": RESTING,
}
WAY_TO = {
    "LIVE": ["LIVE"],
    "STARTING": ["RECORD"],
    "RECORD": ["RECORD", "wait"],
    "STOP": ["STOP"],
    "REPLAY": ["REPLAY"],
    "PLAY": ["SESSION 1", "PLAY"],
    "JOG": ["JOG -1"],
    "SEARCH": ["SEARCH 0"],
}


@pytest.mark.parametrize("mode", WAY_TO)
@pytest.mark.parametrize("command", OBEYED_IN)
def test_each_command_is_obeyed_in_its_modes_and_refused_in_the_others(
    bench: Bench, mode: str, command: str
) -> None:
    bench.recorded(1000)
    bench.ask("SEARCH 500")
    bench.clock.advance(1.0)
    for step in WAY_TO[mode]:
        _ = bench.clock.advance(0.25) if step == "wait" else bench.ask(step)
    assert bench.mode() == mode
    answer = bench.ask(command)
    if mode in OBEYED_IN[command]:
        assert answer.startswith("OK ")
    else:
        assert answer == f"ERR MODE {command.split(maxsplit=1)[0]} not in {mode}"
        assert bench.mode() == mode


COMMANDS = st.sampled_from([*OBEYED_IN, "STATUS?", "PICTURE?", "MARKS?", "SESSIONS?", "STEP -1"])


@given(
    steps=st.lists(st.tuples(COMMANDS | st.booleans(), st.floats(0.0, 40.0)), max_size=30),
)
def test_no_order_of_commands_breaks_the_recorder(steps: list[tuple[str | bool, float]]) -> None:
    class Time:
        now = 0.0

        def __call__(self) -> float:
            return self.now

        def advance(self, seconds: float) -> None:
            self.now += seconds

    bench = Bench(Time())
    for step, pause in steps:
        if isinstance(step, bool):
            bench.processor.contact(step)
        else:
            assert bench.ask(step, after_s=pause).split()[0] in {"OK", "ERR"}
        _, _, _, _, left, place = bench.ask("STATUS?").split()
        assert 0.0 <= float(left) <= 60.0
        assert (place == "EOT") == (float(left) == 0.0)


@given(line=st.binary(max_size=80))
def test_no_bytes_make_the_link_raise_or_record(line: bytes) -> None:
    processor = Processor(lambda: 0.0)
    answer = Link(processor, lambda transfer: None).answer(line)
    assert answer.startswith((b"OK ", b"ERR "))
    if line != b"RECORD":
        assert processor.status().session == 0
