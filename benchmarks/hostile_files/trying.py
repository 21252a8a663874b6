"""One broken file after another in a process of its own, with bounds that the system keeps."""

from __future__ import annotations

import os
import random
import resource
import shutil
import signal
import time
import traceback
import warnings
from multiprocessing.connection import Connection
from pathlib import Path

from analysis.errors import InputError, ShotRefusedError
from benchmarks.hostile_files.breaking import broken
from benchmarks.hostile_files.samples import Sample, samples
from rigctl.errors import RigError

MOST_BYTES = 1_000_000_000
"""Address space beyond what the process has once its readers are loaded."""
LONGEST_S = 5.0
"""Processor time of one file: a busy machine counts nothing against it."""
LONGEST_SENTENCE = 3000


def serve(connection: Connection, seed: int, folder: Path) -> None:
    """Say of which kinds the files are, then of each number that comes what became of its file."""
    room = folder / "samples"
    room.mkdir()
    known = samples(room)
    connection.send([sample.kind for sample in known])
    _bound_memory()
    warnings.simplefilter("error")
    said = folder / "said.txt"
    os.dup2(os.open(said, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o600), 2)
    while (number := connection.recv()) is not None:
        rng = random.Random(f"{seed} {number}")
        sample = known[number % len(known)]
        place = folder / "broken"
        _write(place, sample, known, rng)
        # The process is ended by the system when the time is over, wherever it computes.
        signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
        outcome, words = _outcome(sample, place)
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        shutil.rmtree(place)
        if outcome != "traceback" and said.stat().st_size > 0:
            outcome, words = "traceback", f"lines beside the sentence: {said.read_text()[:500]}"
        os.truncate(said, 0)
        connection.send((outcome, words, time.process_time()))


def _bound_memory() -> None:
    held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (held + MOST_BYTES,) * 2)


def _write(place: Path, sample: Sample, known: list[Sample], rng: random.Random) -> None:
    others = [other.content for other in known]
    content = broken(sample.content, sample.name, others, rng)
    for name, unbroken in ((sample.name, content), *sample.beside):
        path = place / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(unbroken)


def _outcome(sample: Sample, place: Path) -> tuple[str, str]:
    try:
        sample.read(place)
    except (InputError, RigError, ShotRefusedError) as error:
        if _ran_out(error):
            return "memory", str(error)
        text = str(error)
        if "\n" in text.strip() or len(text) > LONGEST_SENTENCE:
            return "traceback", f"no one sentence, {len(text)} characters: {text[:300]!r}"
        return "refused", text
    except MemoryError:
        return "memory", traceback.format_exc()
    except Exception:  # noqa: BLE001 - which errors come through is what is measured
        return "traceback", traceback.format_exc()
    return "read", ""


def _ran_out(error: BaseException | None) -> bool:
    """Return whether a refusal was made of an error about memory."""
    while error is not None:
        words = str(error).lower()
        if isinstance(error, MemoryError) or "insufficient memory" in words:
            return True
        error = error.__cause__ or error.__context__
    return False
