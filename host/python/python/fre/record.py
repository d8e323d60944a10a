"""Results as attributes: what the JSON of the ``fre`` command names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np


class Record(Mapping[str, Any]):
    """A JSON object whose names are attributes and keys. Lists of numbers are arrays, objects are records, null is None."""

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
        """The JSON object as it is."""
        return dict(self._json)

    def __repr__(self) -> str:
        return f"Record({self._json!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Record, (self._json,)


def wrapped(value: Any) -> Any:
    """A JSON value as Python has it."""
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list):
        if value and all(isinstance(entry, dict) for entry in value):
            return tuple(Record(entry) for entry in value)
        if is_numbers(value):
            return array(value)
        return tuple(wrapped(entry) for entry in value)
    return value


def is_numbers(value: Any) -> bool:
    """Whether a list holds numbers, or lists of them, all the way down."""
    if isinstance(value, list):
        return all(is_numbers(entry) for entry in value)
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def array(value: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Numbers as an array that nobody changes."""
    found = np.asarray(value, dtype=np.float64)
    found.flags.writeable = False
    return found
