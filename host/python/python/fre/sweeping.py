"""Sweeps: a grid of a case's numbers."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .case import Case, CaseLike
from .error import case_error
from .options import DEFAULT, Options
from .status import STATUSES, Status

Progress = Callable[[bool, int, int, "float | None"], object]
"""Called with: whether the grid is still checked, how many points or rows are done, of how many, and the seconds left."""


class Sweep(Mapping[str, Any]):
    """Rows of a sweep as columns, by the names of its CSV: ``pandas.DataFrame(dict(sweep))``."""

    __slots__ = ("_columns", "counts")

    def __init__(self, columns: dict[str, Any], counts: dict[str, Any]) -> None:
        self._columns = columns
        self.counts: dict[str, Any] = counts
        """Rows by status, rows computed and resumed, and the numbers of those without a trustworthy status."""

    def __getitem__(self, column: str) -> Any:
        return self._columns[column]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def status(self) -> tuple[Status, ...]:
        """Statuses of the rows."""
        return tuple(STATUSES[word] for word in self._columns["status"])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sweep) and self.counts == other.counts and _same(self._columns, other._columns)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<fre.Sweep of {len(self._columns.get('row', ()))} rows>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Sweep, (self._columns, self.counts)


def sweep(
    case: CaseLike,
    vary: Mapping[str, Sequence[float] | Sequence[str] | NDArray[np.float64]],
    *,
    angles_deg: Sequence[float] | NDArray[np.float64] | None = None,
    out: str | os.PathLike[str] | None = None,
    parquet: str | os.PathLike[str] | None = None,
    shapes: bool = False,
    shard: str | None = None,
    threads: int = 0,
    options: Options = DEFAULT,
    progress: Progress | None = None,
) -> Sweep:
    """Solves a case over the product of lists of values, by the dotted keys of the numbers that they change, in parallel. The key
    ``elements`` takes resolutions as words.

    With ``out`` the rows go into a CSV file, and a stopped sweep goes on in it; the result then has ``counts`` only. The file is that
    of ``fre sweep --out``. With ``parquet`` the complete sweep is written as Parquet as well, in place of an older file. ``shapes``
    adds the points of both centrelines to every row. ``shard="I/N"`` solves the I-th of N parts only: see :func:`merge`.
    """
    if parquet is not None and out is None:
        raise case_error("parquet needs out, where the rows are kept until they are complete", "parquet")
    axes = axes_of(vary)
    angles = None if angles_deg is None else [float(angle) for angle in angles_deg]
    rows = _Rows(_path(out), _path(parquet), shapes, shard)
    columns, counts = _core.sweep(Case.of(case)._case, axes, angles, rows, threads, options, progress)
    return Sweep(columns or {}, counts)


def merge(
    shards: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    parquet: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
) -> int:
    """Makes one file of the files of all shards of a sweep, in any order; gives the number of its rows. It is the file of the whole
    sweep on one machine, but for the times."""
    return _core.merge([os.fspath(shard) for shard in shards], os.fspath(out), _path(parquet), overwrite)


@dataclasses.dataclass(frozen=True)
class _Rows:
    """Where the rows go, and which."""

    out: str | None
    parquet: str | None
    shapes: bool
    shard: str | None
    points: tuple[int, int] | None = None


def _path(path: str | os.PathLike[str] | None) -> str | None:
    return None if path is None else os.fspath(path)


def axes_of(
    vary: Mapping[str, Sequence[float] | Sequence[str] | NDArray[np.float64]],
) -> list[tuple[str, list[float] | list[str]]]:
    """Keys with their values, as the private module takes them."""
    return [(key, _values(key, values)) for key, values in vary.items()]


def _values(key: str, given: Sequence[float] | Sequence[str] | NDArray[np.float64]) -> list[float] | list[str]:
    values = list(given)
    if not values:
        raise case_error(f"{key}: has no values; allowed is one and more", key)
    words = [value for value in values if isinstance(value, str)]
    if words and len(words) < len(values):
        raise case_error(f"{key}: has numbers and texts ({words[0]!r}); allowed is one of both", key)
    return words if words else [float(value) for value in values]


def _same(one: Any, other: Any) -> bool:
    """Whether columns hold the same; NaN is the same as NaN."""
    if isinstance(one, dict):
        return isinstance(other, dict) and one.keys() == other.keys() and all(_same(one[name], other[name]) for name in one)
    if isinstance(one, list):
        return isinstance(other, list) and len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and np.array_equal(one, other, equal_nan=True)
    return bool(one == other)
