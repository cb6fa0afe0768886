# SPDX-License-Identifier: LGPL-3.0-or-later
"""What callers give, read as what it is or refused in one line (InputError)."""
from __future__ import annotations

import difflib
import json
import operator
import os
from typing import Any, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from grus.errors import InputError

Array = NDArray[np.float64]


class Lacking(KeyError):
    """A name that is not there, with those that are near it."""

    def __init__(self, what: str, name: Any, known: Iterable[Any]) -> None:
        names = [str(k) for k in known]
        lower = {n.lower(): n for n in names}
        asked = str(name).lower()
        near = [lower[n] for n in difflib.get_close_matches(asked, lower, 3, 0.6)] if isinstance(name, str) else []
        near = near or [n for n in names if isinstance(name, str) and asked and asked in n.lower()][:3]
        hint = f"did you mean {' or '.join(map(repr, near))}?" if near else f"there are {', '.join(names) or 'none'}"
        super().__init__(f"{what}: no {name!r}; {hint}")
        self._asked = what, name, names

    def __reduce__(self) -> Any:
        return Lacking, self._asked

    def __str__(self) -> str:  # KeyError's own puts the line in quotes
        return str(self.args[0])


class Named(dict):
    """A dict that says what it has where it is asked for what it has not."""

    def __init__(self, what: str, entries: Mapping[Any, Any]) -> None:
        super().__init__(entries)
        self._what = what

    def __missing__(self, name: Any) -> Any:
        raise Lacking(self._what, name, self)

    def __reduce__(self) -> Any:
        return Named, (self._what, dict(self))


def kind(value: Any) -> str:
    """Of a value, for a message: 'float 1.5', 'str', 'float64 array of shape (3, 3)'."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} array of shape {value.shape}"
    name = type(value).__name__
    return f"{name} {value!r}" if isinstance(value, (bool, int, float)) or value is None else name


def path_of(name: str, value: Any) -> str:
    """A path as text; str or os.PathLike."""
    if not isinstance(value, (str, os.PathLike)) or not isinstance(os.fspath(value), str):
        raise InputError(f"{name}: expected a path, given {kind(value)}")
    text = os.fspath(value)
    if not text or "\0" in text:
        raise InputError(f"{name}: {text!r} is no path: " + ("a zero byte ends it" if text else "it is empty"))
    return text


def changes_of(value: Any) -> list[str]:
    """The "KEY=VALUE" changes of a scene."""
    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable) or isinstance(value, dict):
        raise InputError(f'set: expected a list of "KEY=VALUE", not one text ({kind(value)})')
    changes = list(value)
    for change in changes:
        if not isinstance(change, str) or "=" not in change or "\0" in change:
            raise InputError(f'set: expected a list of "KEY=VALUE", given '
                             f'{repr(change) if isinstance(change, str) else kind(change)} in it')
    return changes


def whole_number(name: str, value: Any, least: int) -> int:
    """An int, NumPy's included; no float, however whole, and no bool."""
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise InputError(f"{name}: expected a whole number from {least}, given {kind(value)}") from None
    if not least <= number <= 2 ** 31 - 1:
        raise InputError(f"{name} = {number}: expected a whole number from {least} to {2 ** 31 - 1}")
    return number


def value_text(name: str, value: Any) -> str:
    """A key's value as scenes write it."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, Mapping):
        return f"{{ {', '.join(_assignments(value, name + '.'))} }}"
    if isinstance(value, (str, bool)):
        return json.dumps(value)
    if isinstance(value, (int, float)):
        return repr(value)
    raise InputError(f"{name}: expected a number, a text, True or False, or a dict of them, given {kind(value)}")


def _assignments(settings: Mapping[str, Any], above: str = "") -> list[str]:
    for name in settings:
        if not isinstance(name, str) or not name.isidentifier() or not name.isascii():
            raise InputError(f"unknown key {above}{name!r}" if above else f"unknown key {name!r}")
    return [f"{name} = {value_text(above + name, value)}" for name, value in settings.items()]


def settings_text(settings: Mapping[str, Any]) -> str:
    """Keyword arguments as a table of a scene; a dict as a table in it."""
    return "\n".join(_assignments(settings))


def _fits(shape: tuple[int, ...], n: int, form: tuple[int, ...]) -> bool:
    """`n` times `form`, however the points are counted, or all in one row: never the other way round."""
    size = int(np.prod(form))
    if int(np.prod(shape)) != n * size:
        return False
    return len(shape) == 1 or shape[-len(form):] == form or shape[-1:] == (size,)


def increments_of(dF: Any, n: int) -> Array:
    """n matrices in a row, as float64; a copy only where the caller's memory is laid out otherwise."""
    try:
        given = np.asarray(dF)
    except ValueError:  # rows of different lengths
        raise InputError(f"dF: expected numbers of shape ({n}, 3, 3), given rows of different lengths") from None
    if isinstance(dF, np.ma.MaskedArray) and np.ma.is_masked(dF):
        raise InputError("dF: some of its numbers are masked")
    if given.dtype.kind not in "fiu" or not _fits(given.shape, n, (3, 3)):
        raise InputError(f"dF: expected numbers of shape ({n}, 3, 3), given {given.shape} of {given.dtype}")
    return np.ascontiguousarray(given, dtype=np.float64).reshape(-1)


def room_in(name: str, array: Any, n: int, form: tuple[int, ...]) -> Array:
    """The array itself, as one row: what is written into must not be a copy."""
    if not isinstance(array, np.ndarray) or array.dtype != np.float64 or isinstance(array, np.ma.MaskedArray):
        raise InputError(f"{name}: expected a NumPy array of float64, to be written in place, given {kind(array)}")
    flags = array.flags
    if not (flags.c_contiguous and flags.writeable and flags.aligned):
        raise InputError(f"{name}: expected a writable array in C order, without gaps: to be written in place")
    size = n * int(np.prod(form))
    if array.size != size:
        raise InputError(f"{name}: {array.size} numbers, expected {size}")
    if not _fits(array.shape, n, form):
        wanted = ", ".join(map(str, (n, *form)))
        raise InputError(f"{name}: shape {array.shape}, expected ({wanted}) or one row of {size}: points come first")
    return array.view(np.ndarray).reshape(-1)


def communicator(comm: Any) -> Any:
    """mpi4py's, or what does the same."""
    wanted: Sequence[str] = ("rank", "size", "allgather", "scatter", "send", "recv")
    if comm is not None and not all(hasattr(comm, name) for name in wanted):
        raise InputError(f"comm: expected a communicator of mpi4py, such as MPI.COMM_WORLD, given {kind(comm)}")
    return comm


def state_bytes(state: Any) -> bytes:
    """What get_state has given."""
    if not isinstance(state, (bytes, bytearray, memoryview)):
        raise InputError(f"state: expected the bytes of get_state, given {kind(state)}")
    return bytes(state)
