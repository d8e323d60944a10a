"""Statuses: what qualifies every number."""

from __future__ import annotations

import enum


class Status(enum.Enum):
    """Outcome of a solve or of an estimator's tick. The value is the word in files; the name has ``_`` for ``-``."""

    converged = "converged"
    """All residuals within tolerance on a stable branch."""
    tracking = "tracking"
    """One-iteration mode, residual within its stated bound."""
    no_contact = "no-contact"
    """The finger does not touch the object."""
    snapped = "snapped"
    """Converged after a snap-through."""
    max_iterations = "max-iterations"
    """The iterations allowed were not enough."""
    stagnated = "stagnated"
    """The residual stopped falling above the tolerance."""
    folded = "folded"
    """The branch ended, and no other was found."""
    contact_capacity = "contact-capacity"
    """More samples touch than the model has room for."""
    out_of_range = "out-of-range"
    """The place is outside the range that can be followed."""
    stale = "stale"
    """Older than the present measurement."""
    precision = "precision"
    """The residual stays above the tolerance because of rounding."""
    unsettled = "unsettled"
    """Which samples touch did not settle."""
    updating = "updating"
    """The work is spread over ticks: within 1 % or 0.05 N of the force, whichever is more."""

    @property
    def is_trustworthy(self) -> bool:
        """True if the numbers that come with this status may be used."""
        return self in _TRUSTWORTHY

    def __str__(self) -> str:
        return self.value


_TRUSTWORTHY = frozenset((Status.converged, Status.tracking, Status.no_contact, Status.snapped))

STATUSES: dict[str, Status] = {status.value: status for status in Status}
