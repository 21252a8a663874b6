"""Work in a process of its own, of low priority: it can be killed, and firing never waits for it.

A process serves one job: a worker shared between jobs would hand the memory and the faults of one
to the next. Its start costs a second, which `Ready` spends before it is asked for.
"""

from __future__ import annotations

from rigctl.documents import Json
from rigctl.jobs.attending import attend
from rigctl.jobs.ready import started
from rigctl.jobs.task import Task, Work

LONGEST_S = 3600.0


def in_process(function: str, arguments: Json, longest_s: float = LONGEST_S) -> Work:
    """Return work that calls a function in a process of its own.

    Parameters
    ----------
    function
        `module:name` of a callable (arguments, progress) -> JSON object, imported in the process.
    arguments
        JSON object that is handed over. Where it names a `database`, the process has the network.
    longest_s
        The process is killed when it has not ended after this time, s.

    Returns
    -------
    Work that raises `JobFailedError` when the process cannot be started, dies, breaks or takes
    too long.
    """

    def work(task: Task) -> str:
        process = started(task.ready, function, network=arguments.get("database") is not None)
        try:
            process.order(function, arguments)
            task.on_cancel(process.kill)
            return attend(process, task.progress, longest_s, enclosed=task.enclosed)
        finally:
            process.close()
            if task.ready is not None:
                task.ready.refill_soon()

    return work
