"""Adds forces to a recording of joint positions that was made without them.

Whatever has recorded the arm: its table needs a column of times and one of the gripper's positions.

    python label_forces.py episode.csv labelled.csv --case case.toml --time timestamp --position observation.gripper.pos --scale 0.6

`fre replay` estimates the forces. The labelled table has all columns of the first one, and `gripper.force_n`, `gripper.force_std_n`,
`gripper.trusted` and `gripper.status` (a word). Rows whose force must not be used have no force.
"""

from __future__ import annotations

import argparse
import csv
import pathlib
import subprocess
import tempfile
from collections.abc import Sequence

COLUMNS = {"force_n": "gripper.force_n", "standard_deviation_n": "gripper.force_std_n"}


def label(
    rows: Sequence[dict[str, str]],
    case: str,
    *,
    time: str = "timestamp",
    position: str = "observation.gripper.pos",
    scale: float = 1.0,
    offset: float = 0.0,
    fre: str = "fre",
    settings: Sequence[str] = (),
) -> list[dict[str, str]]:
    """The rows with their forces; motor angle in degrees = scale · position + offset."""
    with tempfile.TemporaryDirectory() as name:
        positions, forces = pathlib.Path(name, "positions.csv"), pathlib.Path(name, "forces.csv")
        with positions.open("w", newline="") as file:
            table = csv.writer(file)
            table.writerow(["time_s", "angle_deg"])
            table.writerows([row[time], repr(scale * number(row, position, line) + offset)] for line, row in enumerate(rows, 2))
        sets = [word for setting in settings for word in ("--set", setting)]
        command = [fre, "replay", str(positions), "--again", "--case", case, "--csv", str(forces), *sets]
        done = subprocess.run(command, capture_output=True, text=True)
        # 2: the table is whole, and some rows have no force.
        if done.returncode not in (0, 2):
            raise RuntimeError(done.stderr.strip())
        with forces.open(newline="") as file:
            found = list(csv.DictReader(file))
    return [{**row, **labels(force)} for row, force in zip(rows, found, strict=True)]


def number(row: dict[str, str], column: str, line: int) -> float:
    """A number of a row."""
    try:
        return float(row[column])
    except ValueError:
        raise SystemExit(f"line {line}, {column}: {row[column]!r} is not a number") from None


def labels(force: dict[str, str]) -> dict[str, str]:
    """What a row gets."""
    named = {name: force[column] for column, name in COLUMNS.items()}
    return {**named, "gripper.trusted": "1" if force["force_n"] else "0", "gripper.status": force["status"]}


def main() -> None:
    """Labels a file."""
    words = argparse.ArgumentParser(description="Adds forces to a recording of joint positions.")
    words.add_argument("table", type=pathlib.Path)
    words.add_argument("labelled", type=pathlib.Path)
    words.add_argument("--case", required=True, help="finger and object")
    words.add_argument("--time", default="timestamp", help="the column of times, s")
    words.add_argument("--position", default="observation.gripper.pos", help="the column of the gripper's positions")
    words.add_argument("--scale", type=float, default=1.0, help="degrees of the motor per unit of the position")
    words.add_argument("--offset", type=float, default=0.0, help="degrees of the motor at position 0")
    words.add_argument("--fre", default="fre", help="the command")
    given = words.parse_args()
    # A spreadsheet begins its files with a mark of the encoding.
    with given.table.open(newline="", encoding="utf-8-sig") as file:
        rows = list(csv.DictReader(file))
    for line, row in enumerate(rows, 2):
        if None in row or None in row.values():
            raise SystemExit(f"{given.table}, line {line}: as many cells as columns are needed")
    if not rows:
        raise SystemExit(f"{given.table} has no rows")
    for column in (given.time, given.position):
        if column not in rows[0]:
            raise SystemExit(f"{given.table} has no column {column}; its columns are {', '.join(rows[0])}")
    done = label(
        rows, given.case, time=given.time, position=given.position, scale=given.scale, offset=given.offset, fre=given.fre
    )
    with given.labelled.open("w", newline="") as file:
        table = csv.DictWriter(file, list(done[0]))
        table.writeheader()
        table.writerows(done)


if __name__ == "__main__":
    main()
