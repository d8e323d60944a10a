"""Fingers."""

from __future__ import annotations

import copy
import numbers
import os
from collections.abc import Iterable, Mapping
from typing import Any

from . import _core
from .error import case_error
from .objects import frozen

PRESETS: tuple[str, ...] = tuple(_core.presets())
"""Names of the fingers that come with the package."""


class Finger:
    """A finger by the keys of ``[finger]`` in a case file; dimensions in mm, with the unit in the name.

    >>> finger = Finger.preset("ladder-80").with_values({"front.thickness_mm": 2.5})
    >>> finger["front.thickness_mm"]
    2.5

    What its keys say is checked by the :class:`fre.Case` that it becomes a part of. A finger never changes.
    """

    __slots__ = ("_table",)

    def __init__(self, table: Mapping[str, Any]) -> None:
        """The finger of a table ``[finger]``, as a dictionary of dictionaries."""
        self._table: dict[str, Any] = _core_table(table)

    @classmethod
    def preset(cls, name: str) -> Finger:
        """A finger that comes with the package: one of ``fre.PRESETS``."""
        return cls.parse(_core.preset(name))

    @classmethod
    def parse(cls, text: str) -> Finger:
        """The finger of a TOML text: its keys at the top, or below ``[finger]``."""
        table = _core.from_toml(text)
        inner = table.get("finger", table)
        return cls.preset(inner.removeprefix("preset:")) if isinstance(inner, str) else cls(inner)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Finger:
        """Reads a finger file."""
        with open(path, encoding="utf-8") as file:
            finger = cls.parse(file.read())
        finger._table.setdefault("name", os.path.splitext(os.path.basename(path))[0])
        return finger

    def to_dict(self) -> dict[str, Any]:
        """The table ``[finger]``; a copy."""
        return copy.deepcopy(self._table)

    def toml(self) -> str:
        """The text of a finger file."""
        return _core.to_toml(self._table)

    @property
    def name(self) -> str:
        """Name for titles."""
        return str(self._table.get("name", "finger"))

    def __getitem__(self, key: str) -> Any:
        """A value by its dotted key, such as ``front.thickness_mm`` or ``lamellae.heights_mm.0``."""
        value: Any = self._table
        for part in key.split("."):
            try:
                value = value[int(part)] if isinstance(value, list) else value[part]
            except (KeyError, IndexError, ValueError, TypeError):
                raise KeyError(key) from None
        return copy.deepcopy(value)

    def with_values(self, values: Mapping[str, Any]) -> Finger:
        """Another finger, with these values at their dotted keys."""
        table = self.to_dict()
        for key, value in values.items():
            *path, last = key.split(".")
            at: Any = table
            for part in path:
                at = at.setdefault(part, {}) if isinstance(at, dict) else at[_index(at, key, part)]
            at[last if isinstance(at, dict) else _index(at, key, last)] = value
        return Finger(table)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Finger) and self._table == other._table

    def __hash__(self) -> int:
        return hash(frozen(self._table))

    def __repr__(self) -> str:
        return f"<fre.Finger {self.name}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Finger, (self._table,)


def _core_table(table: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of plain Python values: arrays and tuples become lists, numbers of numpy Python's."""
    return {str(key): _plain(value) for key, value in table.items() if value is not None}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return _core_table(value)
    if isinstance(value, (str, bool, int, float)):
        return value
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, numbers.Real):
        return float(value)
    if not isinstance(value, Iterable):
        raise TypeError(f"finger: {value!r} is not a number, a text, a list or a table")
    return [_plain(entry) for entry in value]


def _index(at: Any, key: str, part: str) -> int:
    """The number of an entry of a list, as a part of a key says it."""
    if not isinstance(at, list):
        raise case_error(f"finger.{key}: {at!r} is not a table", f"finger.{key}")
    if not part.isdecimal() or int(part) >= len(at):
        raise case_error(f"finger.{key}: {part} is not an entry of the list, which has 0 to {len(at) - 1}", f"finger.{key}")
    return int(part)
