"""A flat board of squares, and its corners in a picture."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Floats

Grey = NDArray[np.uint8]

DICTIONARIES = (cv2.aruco.DICT_4X4_50, cv2.aruco.DICT_5X5_100, cv2.aruco.DICT_6X6_250)
"""Of markers on ChArUco boards, as common generators print them."""
SADDLE = 0.25
"""Half width of the window about a corner, of the shortest square's side."""
_UNTIL = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-3)
LEAST_CORNERS = 8
"""Of a ChArUco board that is partly seen."""


@dataclass(frozen=True, slots=True)
class Board:
    """A chessboard, or a ChArUco board: a chessboard with a marker in each light square.

    Attributes
    ----------
    columns, rows
        Inner corners, where four squares meet; squares are one more each way.
    square_m
        Side of a square.
    marker_m
        Side of a marker; None: a plain chessboard.
    """

    columns: int
    rows: int
    square_m: float
    marker_m: float | None = None

    @property
    def corners(self) -> Floats:
        """Return all inner corners on the board, row by row, m, shape (columns rows, 3)."""
        rows, columns = np.mgrid[: self.rows, : self.columns]
        flat = np.stack([columns.ravel(), rows.ravel(), np.zeros(rows.size)], axis=1)
        return np.asarray(flat * self.square_m)


@dataclass(frozen=True, slots=True, eq=False)
class SeenBoard:
    """Corners that were found in one picture.

    Attributes
    ----------
    on_board
        m, shape (N, 3).
    in_picture
        (column, row), shape (N, 2).
    """

    on_board: Floats
    in_picture: Floats


class BoardFinder:
    """Finds the corners of one board in pictures."""

    def __init__(self, board: Board) -> None:
        self._board, self._corners = board, board.corners
        self._detectors = [] if board.marker_m is None else _detectors(board, board.marker_m)

    def find(self, grey: Grey) -> SeenBoard | None:
        """Return the board's corners in a grey picture; None where the board is not seen.

        All of a chessboard must be seen, of a ChArUco board some corners.
        """
        if self._board.marker_m is None:
            return self._chessboard(grey)
        # The kind of markers is that of the first picture in which enough of them are found.
        for detector in list(self._detectors):
            corners, numbers, _, _ = detector.detectBoard(grey)
            if numbers is not None and len(numbers) >= LEAST_CORNERS:
                self._detectors = [detector]
                places = np.asarray(corners, np.float64).reshape(-1, 2)
                return SeenBoard(self._corners[np.asarray(numbers).ravel()], places)
        return None

    def _chessboard(self, grey: Grey) -> SeenBoard | None:
        size = self._board.columns, self._board.rows
        flags = cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE
        found, corners = cv2.findChessboardCornersSB(grey, size, flags=flags)
        if not found:
            return None
        first = np.asarray(corners, np.float32).reshape(-1, 2)
        # Saddle points by gradients (W. Forstner): twice as near to the truth as those found first.
        steps = np.linalg.norm(np.diff(first.reshape(size[1], size[0], 2), axis=1), axis=2)
        half = max(2, round(SADDLE * float(steps.min())))
        fine = cv2.cornerSubPix(grey, first.reshape(-1, 1, 2), (half, half), (-1, -1), _UNTIL)
        return SeenBoard(self._corners, np.asarray(fine, np.float64).reshape(-1, 2))


def _detectors(board: Board, marker_m: float) -> list[cv2.aruco.CharucoDetector]:
    """Return a detector for each kind of markers, and for both layouts of boards of even rows."""
    found = []
    for name in DICTIONARIES:
        for legacy in (False, True):
            kind = cv2.aruco.getPredefinedDictionary(name)
            size = board.columns + 1, board.rows + 1
            printed = cv2.aruco.CharucoBoard(size, board.square_m, marker_m, kind)
            printed.setLegacyPattern(legacy)
            found.append(cv2.aruco.CharucoDetector(printed))
    return found
