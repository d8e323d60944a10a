"""A bus of this PC and a gripper, with simulated servos; recordings of them."""

from __future__ import annotations

import os
import pathlib
import pickle
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator

import numpy as np
import pandas
import pytest

import fre

PATIENCE_S = 60.0


@pytest.fixture
def folder() -> Iterator[pathlib.Path]:
    """A folder whose path is short enough for sockets."""
    with tempfile.TemporaryDirectory(prefix="fre-") as name:
        yield pathlib.Path(name)


@pytest.fixture
def case_file(case: fre.Case, folder: pathlib.Path) -> pathlib.Path:
    path = folder / "case.toml"
    path.write_text(case.toml())
    return path


def servo(program: str, case_file: pathlib.Path, *words: str) -> subprocess.Popen[str]:
    """A simulated servo that has said that it is ready."""
    model = ["--scheme", "simpson", "--elements", "reduced", "--physics", "extended"]
    command: list[str | pathlib.Path] = [program, "servo", case_file, "--baud", "1000000", *model, *words]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    for line in process.stdout:
        if line.strip() == "ready":
            return process
    _, errors = process.communicate()
    raise AssertionError(errors)


@pytest.fixture
def bus_port(program: str, case_file: pathlib.Path, folder: pathlib.Path) -> Iterator[str]:
    port = folder / "bus"
    process = servo(program, case_file, "--unix", str(port), "--start-deg", "6")
    yield f"unix:{port}"
    process.terminate()
    process.wait(10)


def test_a_bus_of_this_pc_estimates_the_servos_force(bus_port: str, case: fre.Case) -> None:
    bus = fre.Bus(bus_port, case, {"finger.0.zero_counts": 2048, "rate_hz": 100})
    reports = []
    for report in bus.reports(timeout_s=PATIENCE_S):
        reports.append(report)
        if len(reports) >= 50 and report.status.is_trustworthy:
            break
    last = reports[-1]
    # The load holds the servo where it starts but for less than a count's worth of play.
    expected = fre.solve(case.with_motion(fre.Rotation([last.motor_angle_deg])))[0].force_magnitude_n
    assert abs(last.motor_angle_deg - 6.0) < 1.0
    assert abs(last.force_magnitude_n - expected) < 0.02 * expected
    assert [report.sequence for report in reports] == list(range(reports[0].sequence, reports[0].sequence + len(reports)))
    # As long as it takes.
    assert bus.next(1e19) is not None and bus.next(float("inf")) is not None
    for wrong in (-1.0, float("nan")):
        with pytest.raises(fre.CaseError) as error:
            bus.next(wrong)
        assert error.value.key == "timeout_s"
    # By its words: an interval that is not known is not a number, which equals nothing.
    assert repr(pickle.loads(pickle.dumps(last))) == repr(last)


def test_what_a_bus_cannot_take_is_named(folder: pathlib.Path, case: fre.Case) -> None:
    with pytest.raises(OSError):
        fre.Bus(f"unix:{folder}/nobody", case)
    with pytest.raises(fre.CaseError) as error:
        fre.Bus(f"unix:{folder}/nobody", case, {"finger.0.colour": "red"})
    assert error.value.key == "finger.0.colour"


def test_a_recording_is_read_as_columns(program: str, bus_port: str, case_file: pathlib.Path, folder: pathlib.Path) -> None:
    mcap, csv = folder / "r.mcap", folder / "r.csv"
    monitor: list[str | pathlib.Path] = [program, "monitor", "--bus", bus_port, "--case", case_file]
    monitor += ["--set", "rate_hz=100", "--lines", "--seconds", "2"]
    subprocess.run([*monitor, "--record", mcap], check=True, capture_output=True, timeout=PATIENCE_S)
    subprocess.run([program, "replay", mcap, "--csv", csv], check=True, capture_output=True, timeout=PATIENCE_S)
    recording = fre.read_recording(mcap)
    lines = csv.read_text().splitlines()
    names, rows = lines[0].split(","), [line.split(",") for line in lines[1:]]
    assert len(recording) == len(rows) > 20
    assert list(recording.reports) == [*names, "log_time_ns"]
    for index, name in enumerate(names):
        cells = [row[index] for row in rows]
        column = recording[name]
        if isinstance(column, np.ndarray):
            np.testing.assert_array_equal(column, np.array(cells).astype(column.dtype))
        else:
            assert column == cells
    assert recording["force_x_n"].dtype == np.float32
    parquet = folder / "r.parquet"
    subprocess.run([program, "replay", mcap, "--parquet", parquet], check=True, capture_output=True, timeout=PATIENCE_S)
    table = pandas.read_parquet(parquet)
    assert list(table) == names
    for name in names:
        np.testing.assert_array_equal(table[name].to_numpy(), np.asarray(recording[name]), err_msg=name)
    assert (np.diff(recording["log_time_ns"]) >= 0).all()
    assert (recording.missing, recording.damages, recording.is_cut) == (0, [], False)
    assert recording.setup.origin == "bus" and all(isinstance(status, fre.Status) for status in recording.status)
    assert len(recording.of_finger(0)["sequence"]) == len(rows) and len(recording.of_finger(1)["sequence"]) == 0
    again = pickle.loads(pickle.dumps(recording))
    assert again.events == recording.events and len(again) == len(recording)
    with pytest.raises(OSError, match="not an MCAP"):
        fre.read_recording(csv)


@pytest.fixture
def link(program: str, case_file: pathlib.Path, folder: pathlib.Path) -> Iterator[str]:
    """Where a gripper is: the real firmware in QEMU, its servo simulated."""
    image, qemu = os.environ.get("FRE_FIRMWARE_ELF"), shutil.which("qemu-system-arm")
    assert image and qemu, "FRE_FIRMWARE_ELF names no firmware, or there is no QEMU: run `cargo xtask test python`"
    words = [qemu, "-machine", "mps2-an500", "-display", "none", "-monitor", "none"]
    words += ["-semihosting-config", "enable=on,target=native"]
    for name in ("bus", "link"):
        words += ["-chardev", f"socket,id={name},server=on,wait=off,path={folder / name}", "-serial", f"chardev:{name}"]
    board = subprocess.Popen([*words, "-kernel", image], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    end = time.monotonic() + PATIENCE_S
    while not ((folder / "bus").exists() and (folder / "link").exists()):
        assert time.monotonic() < end and board.poll() is None
        time.sleep(0.05)
    process = servo(
        program, case_file, "--connect-unix", str(folder / "bus"), "--start-deg", "-1", "--clock", "requests", "--highest-deg", "14"
    )
    yield f"unix:{folder / 'link'}"
    for running in (process, board):
        running.terminate()
        running.wait(10)


def follow(gripper: fre.Gripper, wanted: Callable[[fre.Report], bool]) -> fre.Report:
    """The first report that is wanted."""
    end = time.monotonic() + PATIENCE_S
    for report in gripper.reports(timeout_s=PATIENCE_S):
        if wanted(report):
            return report
        assert time.monotonic() < end, report
    raise AssertionError("the link has closed")


def insist(order: Callable[[], None]) -> None:
    """Gives an order until it is obeyed: a busy PC loses the servo for a moment now and then."""
    end = time.monotonic() + PATIENCE_S
    while True:
        try:
            return order()
        except OSError:
            assert time.monotonic() < end
            time.sleep(0.2)


def test_a_gripper_grips_and_releases(link: str, case: fre.Case) -> None:
    gripper = fre.Gripper(link)
    assert gripper.info.version["board"] == "mps2"
    gripper.set({"role": "master", "finger.0.zero_counts": 2048, "on_fault": "hold"})
    assert gripper.settings["finger.0.zero_counts"] == "2048"
    gripper.set_case(case)
    with pytest.raises(fre.CaseError) as error:
        gripper.set({"finger.0.speed": 3})
    assert error.value.key == "finger.0.speed"
    with pytest.raises(OSError):
        gripper.grip(force_n=-3.0)
    insist(lambda: gripper.grip(force_n=3.0, speed_deg_per_s=20.0))
    report = follow(gripper, lambda report: report.phase == "gripped")
    assert abs(report.force_magnitude_n - 3.0) < 0.15 and report.status.is_trustworthy
    # Reports of the grip that nobody reads say nothing about what is ordered next.
    time.sleep(1.0)
    before_us = gripper.info.counters.uptime_us
    insist(gripper.release)
    first = follow(gripper, lambda _: True)
    assert first.time_us > before_us and first.phase != "gripped" and gripper.unheard > 0
    follow(gripper, lambda report: report.status.is_trustworthy and report.force_magnitude_n < 0.5)
    assert not gripper.is_closed


def test_a_finger_that_does_not_obey_is_named(link: str) -> None:
    gripper = fre.Gripper(link)
    # There is no second servo.
    servos = {"finger.0.servo_id": 1, "finger.1.servo_id": 2}
    gripper.set({"role": "master", **servos, "finger.0.zero_counts": 2048, "finger.1.zero_counts": 2048})
    insist(lambda: gripper.hold(0))
    for order in (gripper.hold, gripper.release, gripper.relax):

        def both() -> None:
            try:
                order()
            except OSError as error:
                if "finger 1" not in str(error):
                    raise
            else:
                raise AssertionError("a finger without a servo has obeyed")

        insist(both)


def threads() -> list[str]:
    """Names of this program's threads that belong to a gripper; those of other tests have ended."""
    names = [path.read_text().strip() for path in pathlib.Path("/proc/self/task").glob("*/comm")]
    return [name for name in names if name in ("link", "reports", "signs of life")]


def test_a_program_that_waits_counts_as_alive_and_one_that_has_ended_does_not(link: str, case: fre.Case) -> None:
    gripper = fre.Gripper(link)
    gripper.set({"role": "master", "finger.0.zero_counts": 2048, "on_silence": "hold", "silence_ms": 1000})
    gripper.set_case(case)
    # A servo that a busy PC loses stops the motion as well. The silence would end each within some 2 of the 9 degrees.
    for _ in range(3):
        insist(lambda: gripper.close_to(8.0, speed_deg_per_s=2.0))
        report = follow(gripper, lambda report: report.phase != "moving" or report.goal_deg > 7.9)
        if report.phase == "moving":
            break
    assert report.phase == "moving", report
    assert sorted(threads()) == ["link", "reports", "signs of life"]
    insist(lambda: gripper.close_to(-1.0, speed_deg_per_s=2.0))
    del gripper
    end = time.monotonic() + PATIENCE_S
    while threads():
        assert time.monotonic() < end
        time.sleep(0.01)
    time.sleep(2.0)
    assert follow(fre.Gripper(link), lambda report: report.phase == "held").goal_deg > 0.0
