"""Errors of input that name the key at fault."""

from __future__ import annotations

from ._core import CaseError


def case_error(message: str, key: str) -> CaseError:
    """The error of a key, which its message names."""
    error = CaseError(message)
    error.key = key
    return error
