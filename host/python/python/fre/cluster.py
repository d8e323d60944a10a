"""Sweeps, bootstraps and many starts on the machines of a Ray cluster (``pip install fre[ray]``).

``ray.init(address=…)`` says which cluster; without it Ray starts on this machine alone. Work is cut into tasks of some seconds, so that
Ray's own cost per task does not matter. A task whose machine is lost is done again elsewhere.
"""

from __future__ import annotations

import json
import os
import pathlib
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
import pyarrow
import pyarrow.parquet
import ray
from numpy.typing import NDArray

from . import _core
from .calibration import Noise
from .case import Case, CaseLike
from .error import case_error
from .optimisation import MOST, STARTS, TOLERANCE, Optimum, Problem, check_search
from .options import DEFAULT, Options
from .sweeping import _Rows, axes_of

T = TypeVar("T")
X = TypeVar("X")

TASK_S = 2.0
"""How long a task shall take, seconds."""
_RETRIES = 20
"""How often a task begins again whose worker or machine is lost."""
_WAITING = 3
"""Tasks per core that wait for a free one: results that nobody has taken yet stay few."""


def each(function: Callable[[X], T], items: Iterable[X], *, cores: int = 1) -> Iterator[tuple[int, T]]:
    """Calls a function with every item, somewhere in the cluster; gives the items' numbers with the results, as they come.

    What the function raises is raised here. No more than a few tasks per core are under way: results do not pile up.
    """
    remote = ray.remote(num_cpus=cores, max_retries=_RETRIES)(function)
    waiting: dict[Any, int] = {}
    numbered = enumerate(items)
    more = True
    while more or waiting:
        room = max(2, int(_WAITING * _cores() / cores)) - len(waiting)
        while more and room > 0:
            try:
                number, item = next(numbered)
            except StopIteration:
                more = False
                break
            waiting[remote.remote(item)] = number
            room -= 1
        if waiting:
            done, _ = ray.wait(list(waiting), num_returns=1)
            for one in done:
                number = waiting.pop(one)
                try:
                    result: T = ray.get(one)
                except ray.exceptions.RayTaskError as error:
                    cause = error.cause
                    raise cause if isinstance(cause, Exception) else error
                del one
                yield number, result
            del done


def _cores() -> float:
    """Cores of the cluster as it is now."""
    found: Any = ray.cluster_resources  # Ray's own types leave it open.
    return float(found().get("CPU", 1.0))


def sweep(
    case: CaseLike,
    vary: Mapping[str, Sequence[float] | Sequence[str] | NDArray[np.float64]],
    out: str | os.PathLike[str],
    *,
    angles_deg: Sequence[float] | NDArray[np.float64] | None = None,
    shapes: bool = False,
    options: Options = DEFAULT,
    task_s: float = TASK_S,
    progress: Callable[[int, int], object] | None = None,
) -> int:
    """``fre.sweep`` on a cluster, into a Parquet file with the columns of the CSV; gives the number of its rows. The numbers are those
    of one machine, bit for bit, but for the times.

    What is done is kept in the folder ``OUT.parts`` until all is there: the same call goes on after its program was killed.
    ``progress`` is called with the points that are done and all points.
    """
    axes = axes_of(vary)
    text = Case.of(case).toml()
    angles = None if angles_deg is None else [float(angle) for angle in angles_deg]
    points, name = _core.sweep_identity(Case.parse(text)._case, axes, angles, _Rows(None, None, shapes, None), options)
    out = pathlib.Path(out)
    if out.exists():
        found = (pyarrow.parquet.read_metadata(out).metadata or {}).get(b"fre.sweep")
        if found is not None and json.loads(found) == json.loads(name):
            return int(pyarrow.parquet.read_metadata(out).num_rows)
        raise FileExistsError(f"{out} exists and is not this sweep; remove it, or give another name")
    parts = out.with_name(out.name + ".parts")
    parts.mkdir(exist_ok=True)
    identity = parts / "sweep.json"
    is_another = identity.exists() and json.loads(identity.read_text()) != json.loads(name)
    # Before its first points are solved there is nothing to lose.
    if is_another and any(parts.glob("points-*.parquet")):
        raise FileExistsError(f"{parts} holds another sweep; remove it, or give another name")
    _write(identity, name.encode())

    def solve(points: range) -> bytes:
        return _solved(text, axes, angles, shapes, options, points)

    done = [_points(path) for path in parts.glob("points-*.parquet")]
    known = sum(len(one) for one in done)
    if progress is not None:
        progress(known, points)
    gaps = _gaps(done, points)
    if gaps:
        size = _task_size(solve, gaps[0], task_s)
        tasks = [range(first, min(first + size, gap.stop)) for gap in gaps for first in range(gap.start, gap.stop, size)]
        for number, part in each(solve, tasks):
            _write(parts / _file(tasks[number]), part)
            known += len(tasks[number])
            if progress is not None:
                progress(known, points)
            del part
    rows = _join(parts, out, name)
    for path in parts.iterdir():
        path.unlink()
    parts.rmdir()
    return rows


def bootstrap(
    measurements: str | os.PathLike[str],
    case: CaseLike,
    fit: Sequence[str] = ("youngs-modulus", "zero", "object-x", "object-y"),
    samples: int = 200,
    noise: Noise = Noise(),
    *,
    both_ways: bool = False,
    seed: int = 0,
    options: Options = DEFAULT,
) -> NDArray[np.float64]:
    """Fits a file of measurements again and again, to readings drawn from it with replacement: an uncertainty that does not rest on the
    stated noise. A row per sample, a column per parameter; the same for the same seed, whatever the cluster.

    The readings are those of ``fre.calibrate``: rows of an opening motion are left out unless ``both_ways``. A material with memory is
    refused: its readings depend on each other.
    """
    if samples < 1:
        raise case_error(f"samples = {samples}: allowed is 1 and more", "samples")
    case, path = Case.of(case), pathlib.Path(measurements)
    count = _core.count_readings([os.fspath(path)], [case._case], noise, both_ways)
    text, data = case.toml(), path.read_bytes()
    size = max(1, samples // 64)

    def fits(numbers: range) -> NDArray[np.float64]:
        found = []
        with tempfile.TemporaryDirectory(prefix="fre-bootstrap-") as folder:
            file = pathlib.Path(folder) / path.name
            file.write_bytes(data)
            for number in numbers:
                drawn = np.random.default_rng([seed, number]).integers(0, count, count).tolist()
                cases = [Case.parse(text)._case]
                fitted, *_ = _core.calibrate([os.fspath(file)], cases, list(fit), noise, both_ways, options, drawn)
                values = {one["parameter"]: one["value"] for one in json.loads(fitted)["parameters"]}
                found.append([values[name] for name in fit])
        return np.array(found)

    tasks = [range(first, min(first + size, samples)) for first in range(0, samples, size)]
    results = dict(each(fits, tasks))
    return np.concatenate([results[number] for number in range(len(tasks))])


def optimise(
    problem: Problem,
    *,
    starts: int = STARTS,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    most: int = MOST,
    folder: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Optimum:
    """``fre.optimisation.optimise`` on a cluster, a start per task: the same tries, bit for bit.

    Finished starts are kept in ``folder``: the same call goes on after its program was killed. ``progress`` is called with the starts
    that are done and all starts.
    """
    check_search(starts, most, tolerance)
    begin = time.perf_counter()
    kept = None if folder is None else pathlib.Path(folder)
    tries: dict[int, dict[str, Any]] = {}
    if kept is not None:
        kept.mkdir(parents=True, exist_ok=True)
        name = json.dumps([problem.identity, seed, most, tolerance])
        identity = kept / "problem.json"
        if identity.exists() and identity.read_text(encoding="utf-8") != name:
            raise FileExistsError(f"{kept} holds another search; remove it, or give another name")
        _write(identity, name.encode())
        for path in kept.glob("start-*.json"):
            tries[int(path.stem.removeprefix("start-"))] = json.loads(path.read_text(encoding="utf-8"))

    def search(number: int) -> dict[str, Any]:
        # A task has one core: the differences of a gradient are not spread over others.
        os.environ["RAYON_NUM_THREADS"] = "1"
        return problem.search(number, seed=seed, most=most, tolerance=tolerance)

    todo = [number for number in range(starts) if number not in tries]
    if progress is not None:
        progress(starts - len(todo), starts)
    for index, found in each(search, todo):
        tries[todo[index]] = found
        if kept is not None:
            _write(kept / f"start-{todo[index]:06}.json", json.dumps(found).encode())
        if progress is not None:
            progress(len([number for number in tries if number < starts]), starts)
    return Optimum(problem, [tries[number] for number in range(starts)], time.perf_counter() - begin)


def _solved(
    text: str, axes: Any, angles: list[float] | None, shapes: bool, options: Options, points: range
) -> bytes:
    """The rows of some points as Parquet, solved by one thread. The program that asked has nothing left to do but to write them: it is
    one for the whole cluster."""
    rows = _Rows(None, None, shapes, None, (points.start, points.stop))
    columns, _ = _core.sweep(Case.parse(text)._case, axes, angles, rows, 1, options, None)
    assert columns is not None
    sink = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(pyarrow.table({name: _array(name, column) for name, column in columns.items()}), sink)
    found: bytes = sink.getvalue().to_pybytes()
    return found


def _array(name: str, column: Any) -> pyarrow.Array:
    """A column as Arrow has it: what is not known is null. The type is the same for any rows."""
    kind = _core.column_kind(name)
    if kind == "number":
        return pyarrow.array(column, pyarrow.float64(), from_pandas=True)
    if kind == "integer":
        return pyarrow.array([None if value != value else int(value) for value in column.tolist()], pyarrow.int64())
    types = {"flag": pyarrow.bool_(), "word": pyarrow.string(), "list": pyarrow.list_(pyarrow.float64())}
    return pyarrow.array(column, types[kind])


def _task_size(solve: Callable[[range], bytes], gap: range, task_s: float) -> int:
    """Points of a task: solves a few here to see what one takes."""
    # The first call also loads what later ones find loaded: it says nothing about them.
    solve(range(gap.start, gap.start + 1))
    count = 1
    while True:
        begin = time.perf_counter()
        solve(range(gap.start, gap.start + count))
        seconds = time.perf_counter() - begin
        if seconds >= 0.2 or count == len(gap):
            break
        count = min(8 * count, len(gap))
    return max(1, int(np.ceil(task_s * count / max(seconds, 1e-9))))


def _file(points: range) -> str:
    return f"points-{points.start:09}-{points.stop:09}.parquet"


def _points(path: pathlib.Path) -> range:
    _, first, end = path.stem.split("-")
    return range(int(first), int(end))


def _gaps(done: list[range], points: int) -> list[range]:
    """What is between and behind the points that are done."""
    gaps, at = [], 0
    for one in sorted(done, key=lambda points: points.start):
        if one.start > at:
            gaps.append(range(at, one.start))
        at = max(at, one.stop)
    return [*gaps, range(at, points)] if at < points else gaps


def _write(path: pathlib.Path, data: Any) -> None:
    """Writes a file at once: whole, or not at all."""
    beside = path.with_name(path.name + ".partial")
    with open(beside, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    os.replace(beside, path)


def _join(parts: pathlib.Path, out: pathlib.Path, name: str) -> int:
    """One file of all parts, in the order of the points; takes the memory of one part."""
    files = sorted(parts.glob("points-*.parquet"))
    schema = pyarrow.parquet.read_schema(files[0]).with_metadata({b"fre.sweep": name.encode()})
    beside, rows = out.with_name(out.name + ".partial"), 0
    with pyarrow.parquet.ParquetWriter(beside, schema) as writer:
        for file in files:
            table = pyarrow.parquet.read_table(file)
            rows += table.num_rows
            writer.write_table(table.cast(schema))
    os.replace(beside, out)
    return rows
