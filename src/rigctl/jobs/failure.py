"""Why a job failed, where its work did not say so in an error of its own."""

from __future__ import annotations

from rigctl.errors import RigError


class JobFailedError(RigError):
    """Long work broke, took too long, or its process died.

    Parameters
    ----------
    what, limit, todo
        As every error of the tree.
    because
        The stable code of the error that the work itself raised, where it has one.
    """

    code = "job-failed"

    def __init__(
        self,
        what: str,
        *,
        limit: str | None = None,
        todo: str | None = None,
        because: str | None = None,
    ) -> None:
        self.because = because or self.code
        super().__init__(what, limit=limit, todo=todo)
