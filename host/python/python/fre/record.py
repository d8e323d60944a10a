"""Results as attributes: what the JSON of the ``fre`` command names."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Record(Mapping[str, Any]):
    """A JSON object whose names are attributes and keys. Lists of numbers are arrays, objects are records, null is None. Lists of
    different lengths are a tuple of arrays."""

    __slots__ = ("_json", "_seen")

    def __init__(self, json: Mapping[str, Any]) -> None:
        self._json = dict(json)
        self._seen: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"{name}; there is {', '.join(self._json)}") from None

    def __getitem__(self, name: str) -> Any:
        if name not in self._seen:
            self._seen[name] = wrapped(self._json[name])
        return self._seen[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._json)

    def __len__(self) -> int:
        return len(self._json)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._json]

    def to_dict(self) -> dict[str, Any]:
        """The JSON object as it is; a copy."""
        return copy.deepcopy(self._json)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Record):
            return self._json == other._json
        return isinstance(other, Mapping) and self._json == other

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Record({self._json!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Record, (self._json,)


def wrapped(value: Any) -> Any:
    """A JSON value as Python has it."""
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list):
        if _sizes(value) is not None:
            return array(value)
        return tuple(wrapped(entry) for entry in value)
    return value


def _sizes(value: Any) -> tuple[int, ...] | None:
    """How many numbers a list holds along each direction, () of a number; None where it is not rectangular or holds anything else."""
    if isinstance(value, list):
        inner = {_sizes(entry) for entry in value}
        below = inner.pop() if inner else ()
        return None if inner or below is None else (len(value), *below)
    return () if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def array(value: Any) -> NDArray[np.float64]:
    """Numbers as an array that nobody changes."""
    return fixed(np.array(value, dtype=np.float64))


def fixed(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The array, which nobody changes from now on."""
    values.flags.writeable = False
    return values
