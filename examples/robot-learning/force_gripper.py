"""Adds the gripper's force to what a robot observes, for LeRobot and programs like it.

The gripper of the follower arm has Fin-Ray fingers on Dynamixel servos, on a bus that this program may read. `ForceGripper` wraps the
arm: everything goes through to it, and its observations get the force of one finger, its status and the margin of the whole grip. A margin
needs two fingers at least and friction in the case; without them it is NaN.

    arm = ForceGripper(make_robot(...), fre.Bus("/dev/ttyUSB1", "case.toml", {"finger.0.zero_counts": 2048}))
    arm.get_observation()["gripper.force_n"]

Nothing of LeRobot is imported: an arm is whatever has `get_observation()`, which gives a dictionary, and `observation_features`.

    python force_gripper.py --bus unix:bus --case ../cylinder-mid.toml        prints observations of an arm without joints
"""

from __future__ import annotations

import argparse
import json
import math
import threading
import time
from typing import Any

import fre

# What is added, and its types. A learning program stores numbers: the status is its place in `fre.Status`.
FEATURES = {"gripper.force_n": float, "gripper.margin": float, "gripper.trusted": float, "gripper.status": float}
# Without a report for this long the force is stale.
STALE_S = 0.1


class ForceGripper:
    """A robot whose observations have the force of its gripper."""

    def __init__(self, robot: Any, bus: Any, finger: int = 0) -> None:
        self._robot = robot
        self._finger = finger
        self._newest: tuple[float, fre.Report] | None = None
        self._margin: tuple[float, float] | None = None
        self._stop = threading.Event()
        self._reader = threading.Thread(target=self._read, args=(bus,), daemon=True)
        self._reader.start()

    def _read(self, bus: Any) -> None:
        while not self._stop.is_set() and not bus.is_closed:
            told = bus.next(timeout_s=0.1)
            if isinstance(told, fre.Report) and told.finger == self._finger:
                self._newest = time.monotonic(), told
            elif isinstance(told, fre.Grasp):
                self._margin = (time.monotonic(), told.margin.weakest_n) if told.margin else None

    @property
    def observation_features(self) -> dict[str, Any]:
        """Those of the robot, and the force's."""
        return {**self._robot.observation_features, **FEATURES}

    def get_observation(self) -> dict[str, Any]:
        """That of the robot, and the force at the same moment. A force that must not be used is NaN."""
        return {**self._robot.get_observation(), **self.force()}

    def force(self) -> dict[str, float]:
        """What is added to an observation."""
        newest = self._newest
        if newest is None or time.monotonic() - newest[0] > STALE_S:
            status, force = fre.Status.stale, math.nan
        else:
            report = newest[1]
            status = report.status
            trusted = status.is_trustworthy and report.age == 0
            force = report.force_magnitude_n if trusted else math.nan
        margin = self._margin
        known = margin is not None and time.monotonic() - margin[0] <= STALE_S
        return {
            "gripper.force_n": force,
            # The load that all fingers together bear in the weakest direction before the object slips, N.
            "gripper.margin": margin[1] if margin and known else math.nan,
            "gripper.trusted": float(not math.isnan(force)),
            "gripper.status": float(list(fre.Status).index(status)),
        }

    def close(self) -> None:
        """Reads no more; the robot stays as it is."""
        self._stop.set()
        self._reader.join()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._robot, name)


class NoArm:
    """Stands in for a robot."""

    observation_features: dict[str, Any] = {}

    def get_observation(self) -> dict[str, Any]:
        """It observes nothing."""
        return {}


def main() -> None:
    """Prints ten observations a second."""
    words = argparse.ArgumentParser(description="Prints observations of a gripper on a bus.")
    words.add_argument("--bus", required=True, help="PORT, PORT@BAUD, unix:PATH or tcp:HOST:PORT")
    words.add_argument("--case", required=True, help="finger and object, for all fingers")
    words.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a setting, as finger.0.zero_counts=2048")
    words.add_argument("--count", type=int, default=0, help="how many [default: until stopped]")
    given = words.parse_args()
    settings = dict(pair.split("=", 1) for pair in given.set)
    arm = ForceGripper(NoArm(), fre.Bus(given.bus, given.case, settings))
    number = 0
    while not given.count or number < given.count:
        time.sleep(0.1)
        print(json.dumps(arm.get_observation()), flush=True)
        number += 1
    arm.close()


if __name__ == "__main__":
    main()
