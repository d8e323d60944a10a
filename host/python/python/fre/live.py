"""A gripper behind its link, and servos on a bus of this PC."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple, Union

import numpy as np

from . import _core
from .case import Case, CaseLike
from .options import DEFAULT, Options
from .record import Record
from .status import STATUSES, Status


class Report(NamedTuple):
    """One finger's part of one tick of the control loop; the names are those of ``fre monitor``'s CSV."""

    sequence: int
    time_us: int
    motor_angle_deg: float
    goal_deg: float
    position_counts: int
    current_ma: float
    status: Status
    age: int
    force_x_n: float
    force_y_n: float
    contact_x_mm: float
    contact_y_mm: float
    contact_extent_mm: float
    torque_nmm: float
    distance_mm: float
    iterations: int
    residual_nmm: float
    cost: int
    finger: int
    phase: str
    force_x_per_deg_n: float
    force_y_per_deg_n: float
    standard_deviation_n: float
    sensitivity_age: int
    force_interval_low_n: float
    force_interval_high_n: float
    normal_interval_low_n: float
    normal_interval_high_n: float
    torque_interval_low_nmm: float
    torque_interval_high_nmm: float
    loaded_rib: int
    """The rib that is near its buckling load, from 1 at the base; 0 if none is."""
    rib_load_percent: int
    """Its force in percent of that load; 0 if none is."""

    @property
    def force_magnitude_n(self) -> float:
        """Magnitude of the force, N."""
        return float((self.force_x_n**2 + self.force_y_n**2) ** 0.5)


class Event(NamedTuple):
    """Something that happened."""

    time_us: int
    """When, µs since the start."""
    words: str
    """What."""


class Margin(NamedTuple):
    """What a grip bears before the object slips: the largest loads at the object's reference point (centre; of a polygon, the mean of
    its corners) for which there are forces within the friction cones, no finger pressing harder than now. Frame of the gripper: x from
    left to right, y along the open fingers."""

    least_n: float
    """Force in the weakest direction in the fingers' plane, of directions every 15°, N."""
    direction_deg: float
    """That direction, from x, counter-clockwise."""
    across_n: float
    """Force across the plane, N."""
    couple_nmm: float
    """Couple about the reference point, the weaker one of both ways."""
    slips: int | None
    """The finger that slips first; None where none slides, or where nothing is borne."""
    carried_n: float | None
    """Force in the direction of the weight that the fingers were asked to carry; None if they were not."""
    age: int
    """Ticks since the contact forces behind it were estimated."""

    @property
    def weakest_n(self) -> float:
        """Force in the weakest direction, in the plane or across it, N."""
        return min(self.least_n, self.across_n)


class FreeObject(NamedTuple):
    """Where a free object has come to, from where it was set."""

    status: Status
    shift_x_mm: float
    shift_y_mm: float
    turn_deg: float
    """Counter-clockwise."""
    residual_n: float
    """What is left of the forces and the load (a moment over the object's size)."""


class Grasp(NamedTuple):
    """The whole grasp at one tick, behind the reports of its fingers; one finger has none. Frame of the gripper."""

    sequence: int
    """That of the tick's last report."""
    is_trustworthy: bool
    """Whether all estimates of this tick can be trusted; the forces must not be used otherwise."""
    sum_x_n: float
    """Force of all fingers on the object."""
    sum_y_n: float
    squeeze_n: float
    """Force by which the object is pressed together across x."""
    balance: float
    """How much of the fingers' forces cancels: 1 − abs(sum) / sum of abs; 1 without contact."""
    free: FreeObject | None
    """None for an object that is fixed."""
    margin: Margin | None
    """None while an estimate cannot be trusted, of an object without an end (a half-plane), and until it is known."""


Told = Union[Report, Event, Grasp]
_STATUS = Report._fields.index("status")


def _told(heard: tuple[Any, ...] | None) -> Told | None:
    if heard is None:
        return None
    if len(heard) == 2:
        return Event(*heard)
    if len(heard) == 3:
        own, free, margin = heard
        moved = free and FreeObject._make([STATUSES[free[0]], *free[1:]])
        return Grasp._make([*own, moved, margin and Margin._make(margin)])
    return Report._make([*heard[:_STATUS], STATUSES[heard[_STATUS]], *heard[_STATUS + 1 :]])


class _Source:
    """What reports and events come from. What nobody reads waits: 131,072 messages, the newest ones."""

    _core: _core.Gripper | _core.Bus

    def next(self, timeout_s: float = 1.0) -> Told | None:
        """The next report, event or grasp; None if nothing came in time, or nothing comes any more. An infinite time has no end."""
        return _told(self._core.next(timeout_s))

    def reports(self, timeout_s: float = 1.0) -> Iterator[Report]:
        """Reports as they come, until none came for ``timeout_s``."""
        while (told := self.next(timeout_s)) is not None:
            if isinstance(told, Report):
                yield told

    @property
    def unheard(self) -> int:
        """Reports, events and grasps that came and that nobody has read or will read: newer ones took their place, or an order was
        given after them."""
        return self._core.unheard()

    @property
    def is_closed(self) -> bool:
        """Whether nothing more comes."""
        return self._core.is_closed()


class Gripper(_Source):
    """A connection to a gripper. ``OSError`` is what the link or the gripper refuses, and names the fingers that have not obeyed.

    An order (``grip``, ``close_to``, ``release``, ``hold``, ``relax``) returns when it begins. Reports and grasps of before it are not
    read any more, so that the next report is one of this order; events stay, each with its time.

    While this object lives, the gripper gets signs of life: ``on_silence`` is for a program that has ended or was cut off.

    >>> gripper = fre.Gripper("/dev/ttyACM0")              # doctest: +SKIP
    >>> gripper.set_case("case.toml")                      # doctest: +SKIP
    >>> gripper.grip(force_n=3.0)                          # doctest: +SKIP
    >>> for report in gripper.reports():                   # doctest: +SKIP
    ...     print(report.force_magnitude_n, report.status, report.phase)
    """

    _core: _core.Gripper

    def __init__(self, address: str) -> None:
        """Connects: ``unix:PATH``, ``tcp:HOST:PORT``, or a serial port as ``PORT`` or ``PORT@BAUD``."""
        self._core = _core.Gripper(address)

    @property
    def info(self) -> Record:
        """Who answers (``version``), how it started (``boot``) and what it has counted (``counters``)."""
        return Record(json.loads(self._core.info()))

    @property
    def settings(self) -> dict[str, str]:
        """Its settings by their keys, such as ``finger.0.zero_counts``."""
        return dict(self._core.settings())

    def set(self, settings: Mapping[str, object]) -> None:
        """Changes settings, all at once."""
        words = {True: "true", False: "false"}
        self._core.set([(key, words[bool(value)] if isinstance(value, (bool, np.bool_)) else str(value)) for key, value in settings.items()])

    def set_case(
        self, case: CaseLike, finger: int = 0, physics: Literal["paper", "extended"] = "extended"
    ) -> None:
        """Gives a finger the design and the object of a case; its estimate starts anew."""
        self._core.set_case(Case.of(case)._case, finger, physics)

    def grip(
        self,
        force_n: float,
        finger: int | None = None,
        *,
        speed_deg_per_s: float | None = None,
        limit_deg: float | None = None,
    ) -> None:
        """Closes until a force on the object is reached, and keeps it."""
        self._core.grip(force_n, finger, speed_deg_per_s, limit_deg)

    def close_to(self, angle_deg: float, finger: int | None = None, *, speed_deg_per_s: float | None = None) -> None:
        """Closes to a motor angle."""
        self._core.close_to(angle_deg, finger, speed_deg_per_s)

    def release(self, finger: int | None = None) -> None:
        """Opens."""
        self._core.release(finger)

    def hold(self, finger: int | None = None) -> None:
        """Stays where it is."""
        self._core.hold(finger)

    def relax(self, finger: int | None = None) -> None:
        """Switches the torque off: the finger yields, and lets go of what it holds. The next motion switches it on."""
        self._core.relax(finger)


class Bus(_Source):
    """Servos on a Dynamixel bus of this PC (U2D2 or a like adapter). The estimator runs here; the servos are only read.

    >>> bus = fre.Bus("/dev/ttyUSB0", "case.toml")         # doctest: +SKIP
    >>> for report in bus.reports():                       # doctest: +SKIP
    ...     print(report.finger, report.force_magnitude_n, report.status)
    """

    _core: _core.Bus

    def __init__(
        self,
        port: str,
        cases: CaseLike | Sequence[CaseLike],
        settings: Mapping[str, object] | None = None,
        options: Options = DEFAULT,
    ) -> None:
        """Opens a port (``PORT``, ``PORT@BAUD``, ``unix:PATH`` or ``tcp:HOST:PORT``), finds the servos, and begins to estimate.

        ``cases`` give finger and object, one per finger, the last one for all behind it. ``settings`` have the keys of
        ``fre gripper get``: ``finger.0.servo_id``, ``finger.0.zero_counts``, ``rate_hz`` and so on.
        """
        each = list(cases) if isinstance(cases, Sequence) and not isinstance(cases, str) else [cases]
        words = {True: "true", False: "false"}
        changes = [
            (key, words[bool(value)] if isinstance(value, (bool, np.bool_)) else str(value)) for key, value in (settings or {}).items()
        ]
        self._core = _core.Bus(port, [Case.of(case)._case for case in each], changes, options)

    @property
    def notes(self) -> list[str]:
        """What makes this bus slower than it could be."""
        return self._core.notes()
