"""The process in which shots are analysed, one after another; replaced when it dies."""

from __future__ import annotations

import json
import threading
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from rigctl.documents import Json
from rigctl.errors import RigError
from rigctl.jobs.attending import attend
from rigctl.jobs.failure import JobFailedError
from rigctl.jobs.worker_process import WorkerProcess, conditions

CLOSE_WAIT_S = 5.0


class AnalysisFailedError(RigError):
    """The analysis itself broke, as opposed to a shot that it refused."""

    code = "analysis-failed"


def cancelled() -> AnalysisFailedError:
    """Return the error of an analysis that somebody cancelled."""
    return AnalysisFailedError(
        "its analysis was cancelled; its frames are kept", todo="have it analysed again"
    )


@dataclass(frozen=True, slots=True)
class Compiling:
    """How far a process is that compiles its functions to machine code: in words, and as a share.

    The share goes from 0 to 1.
    """

    words: str
    share: float


class AnalysisProcess:
    """One process, started when it is first needed and again after it was lost.

    Parameters
    ----------
    function
        `module:name` of a callable (arguments, progress) -> JSON object, imported in the process.
        Arguments are the `folder` and the `method`; progress, how far its compilation is.
    loads
        Modules that the process imports at its start: what a shot needs is slow to load.

    Attributes
    ----------
    compiling
        How far it is, while the shot under way waits for machine code; None: it waits for none.
    """

    def __init__(self, function: str, loads: Sequence[str] = ()) -> None:
        self._function, self._loads = function, tuple(loads)
        self._lock = threading.Lock()
        self._process: WorkerProcess | None = None
        self._analyses = self._is_unwanted = False
        self.ended = False
        self.compiling: Compiling | None = None

    def prepare(self) -> None:
        """Start the process before there is a shot; where it cannot be, its first shot says so."""
        with self._lock, suppress(JobFailedError, AnalysisFailedError):
            self._running()

    def analyse(self, folder: Path, method: str, timeout_s: float) -> Json:
        """Have one folder analysed; raise `AnalysisFailedError` if no result comes of it.

        Each function that is compiled meanwhile gives the analysis its time anew.
        """
        try:
            with self._lock:
                if self._is_unwanted:
                    raise cancelled()
                process = self._running()
                self._analyses = True
            process.order(self._function, {"folder": str(folder), "method": method})
            result: Json = json.loads(attend(process, self._compiles, timeout_s, renewed=True))
        except JobFailedError as error:
            if self._is_unwanted:
                raise cancelled() from error
            raise AnalysisFailedError(
                f"the analysis failed: {error.what}", limit=error.limit, todo=error.todo
            ) from error
        finally:
            self.compiling = None
            with self._lock:
                # Killed after its result came, it may still look alive to the next shot.
                killed = self._analyses and self._is_unwanted
                self._analyses = False
                if self.ended or killed:
                    self._discard()
        return result

    def expect(self) -> None:
        """Forget an earlier `cancel`: the analysis that comes next is wanted."""
        self._is_unwanted = False

    def cancel(self) -> None:
        """Have the analysis under way, or since `expect` the next one, raise at once.

        The process of one that is under way is killed.
        """
        with self._lock:
            self._is_unwanted = True
            if self._analyses and self._process is not None:
                self._process.kill()

    def _compiles(self, words: str, share: float | None) -> None:
        self.compiling = Compiling(words, share or 0.0)

    def end(self) -> None:
        """Kill the process; a waiting caller gets the error at once."""
        with self._lock:
            self.ended = True
            if self._analyses and self._process is not None:
                # Who waits for it gives back its pipe.
                self._process.kill()
            else:
                self._discard()

    def _running(self) -> WorkerProcess:
        if self.ended:
            raise AnalysisFailedError("the daemon ends")
        if self._process is None or not self._process.alive:
            self._discard()
            self._process = WorkerProcess(conditions(network=False, loads=self._loads), niceness=0)
        return self._process

    def _discard(self) -> None:
        if self._process is not None:
            self._process.close()
            self._process = None
