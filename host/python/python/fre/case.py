"""Cases: a finger, an object and a motion."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Union

from . import _core
from . import motion as motions
from . import objects
from .error import case_error
from .finger import Finger

CaseLike = Union["Case", str, "os.PathLike[str]"]
"""A case, or the path of a case file."""


class Case:
    """A case: what is computed. Checked when it is made; it never changes.

    Raises :class:`fre.CaseError`, a ``ValueError`` with the ``key`` at fault, for anything that cannot be computed.
    """

    __slots__ = ("_case",)

    def __init__(self, finger: Finger | str, object: objects.Object, motion: motions.Motion) -> None:
        """A case of a finger (or ``"preset:NAME"``), an object and a motion."""
        table = {
            "finger": finger if isinstance(finger, str) else finger.to_dict(),
            "object": object.to_dict(),
            "motion": motion.to_dict(),
        }
        self._case = _core.Case.parse(_core.to_toml(table))

    @classmethod
    def _of(cls, core: _core.Case) -> Case:
        case = cls.__new__(cls)
        case._case = core
        return case

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Case:
        """Reads a case file; a preset or a finger file that it names is written out."""
        return cls._of(_core.Case.read(os.fspath(path)))

    @classmethod
    def parse(cls, text: str) -> Case:
        """Reads a case from a TOML text."""
        return cls._of(_core.Case.parse(text))

    @classmethod
    def of(cls, case: CaseLike) -> Case:
        """The case itself, or the one in the file of this path."""
        return case if isinstance(case, Case) else cls.read(case)

    def toml(self) -> str:
        """The text of a case file."""
        return self._case.toml()

    def to_dict(self) -> dict[str, Any]:
        """The tables ``finger``, ``object`` and ``motion``."""
        return _core.from_toml(self._case.toml())

    @property
    def finger(self) -> Finger:
        """The finger."""
        return Finger(self.to_dict()["finger"])

    @property
    def object(self) -> objects.Object:
        """The object."""
        return objects.read(self.to_dict()["object"])

    @property
    def motion(self) -> motions.Motion:
        """The motion."""
        return motions.read(self.to_dict()["motion"])

    def keys(self) -> list[str]:
        """Dotted keys of the numbers that :meth:`with_values` and ``fre.sweep`` can change."""
        return self._case.keys()

    def with_values(self, values: Mapping[str, float]) -> Case:
        """Another case, with these numbers at their dotted keys, such as ``object.centre_mm.1``."""
        return Case._of(self._case.with_values([(key, _number(key, value)) for key, value in values.items()]))

    def with_motion(self, motion: motions.Motion) -> Case:
        """Another case, with this motion."""
        table = {**self.to_dict(), "motion": motion.to_dict()}
        return Case.parse(_core.to_toml(table))

    def __eq__(self, other: Any) -> bool:
        return isinstance(other, Case) and self._case == other._case

    def __hash__(self) -> int:
        return hash(self._case)

    def __repr__(self) -> str:
        table = self.to_dict()
        return f"<fre.Case {table['finger'].get('name', 'finger')} on {table['object']['shape']}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Case.parse, (self.toml(),)


def _number(key: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise case_error(f"{key}: allowed is a number, not {value!r}", key) from None
