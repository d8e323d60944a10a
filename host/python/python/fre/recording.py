"""Recordings (MCAP) of a gripper or a bus."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from . import _core
from .live import Event
from .record import Record
from .status import STATUSES, Status


class Recording:
    """A recording: every report as columns, the events, and what is missing."""

    __slots__ = ("damages", "events", "is_cut", "missing", "reports", "setup")

    def __init__(self, found: dict[str, Any]) -> None:
        self.setup = Record(json.loads(found["setup"]))
        """Settings, fingers and objects with which it begins."""
        self.reports: dict[str, Any] = found["reports"]
        """Columns of the reports by the names of ``fre replay --csv``, and ``log_time_ns``, ns since 1970."""
        self.events: list[Event] = [Event(*event) for event in found["events"]]
        """What happened."""
        self.missing: int = found["missing"]
        """Reports that did not come, or were lost with a part of the file."""
        self.damages: list[str] = found["damages"]
        """Parts of the file that cannot be read."""
        self.is_cut: bool = found["is_cut"]
        """Whether the end of the file is missing."""

    def __len__(self) -> int:
        return len(self.reports["sequence"])

    def __getitem__(self, column: str) -> Any:
        """A column of the reports."""
        return self.reports[column]

    @property
    def status(self) -> tuple[Status, ...]:
        """Statuses of the reports."""
        return tuple(STATUSES[word] for word in self.reports["status"])

    def of_finger(self, finger: int) -> dict[str, Any]:
        """The columns of one finger's reports."""
        rows = np.flatnonzero(np.asarray(self.reports["finger"]) == finger)
        return {
            name: column[rows] if isinstance(column, np.ndarray) else [column[row] for row in rows]
            for name, column in self.reports.items()
        }

    def __repr__(self) -> str:
        return f"<fre.Recording of {len(self)} reports>"

    def __reduce__(self) -> tuple[Any, ...]:
        found = {
            "setup": json.dumps(self.setup.to_dict()),
            "reports": self.reports,
            "events": [tuple(event) for event in self.events],
            "missing": self.missing,
            "damages": self.damages,
            "is_cut": self.is_cut,
        }
        return Recording, (found,)


def read_recording(path: str | os.PathLike[str]) -> Recording:
    """Reads a recording, past what is damaged, and also one whose end is missing."""
    return Recording(_core.read_recording(os.fspath(path)))
