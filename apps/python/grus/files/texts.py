# SPDX-License-Identifier: LGPL-3.0-or-later
"""Texts: those of files that people bring, in whatever encoding; and those that people are told."""
from __future__ import annotations

import tomllib
from typing import Any

from grus.errors import InputError


class BadData(ValueError):
    """A file that cannot be read, or could be read in two ways; its text is one line."""


def encoding_of(raw: bytes) -> str:
    """UTF-16 where its mark says so, else UTF-8 with or without its own."""
    return "utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"


def packed(raw: bytes) -> bool:
    """gzip, zip, bzip2, xz or zstd, by its first bytes."""
    return raw.startswith((b"\x1f\x8b", b"PK\3\4", b"BZh", b"\xfd7zX", b"\x28\xb5\x2f\xfd"))


def text_of(path: str) -> str:
    """The file's text: UTF-8 or UTF-16 with or without its mark, or else a Windows code page."""
    try:
        with open(path, "rb") as f:
            raw = f.read()
    except OSError as e:
        raise BadData(f"cannot read {path}: {e.strerror}") from None
    if packed(raw):
        raise BadData(f"cannot read {path}: the file is compressed; unpack it first")
    told = encoding_of(raw)
    for encoding in [told] if told == "utf-16" else [told, "cp1252"]:
        try:
            text = raw.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise BadData(f"cannot read {path}: not a text file")


def toml_of(path: str) -> dict[str, Any]:
    """A TOML file, UTF-8 or UTF-16, with or without a byte order mark. Raises OSError and ValueError."""
    with open(path, "rb") as f:
        raw = f.read()
    if packed(raw):
        raise ValueError("the file is compressed; unpack it first")
    return tomllib.loads(raw.decode(encoding_of(raw)))


def tables_of(path: str, what: str = "file") -> dict[str, Any]:
    """The same for whoever is told of a fault: InputError of one line, which names the file."""
    try:
        return toml_of(path)
    except OSError as e:
        raise InputError(f"{path}: no such {what}: {e.strerror}") from None
    except (ValueError, RecursionError) as e:
        raise InputError(f"{path}: {one_line(e)}") from None


def one_line(text: object) -> str:
    """Text without line ends or other control characters: a message is one line."""
    return "".join(c if c.isprintable() else " " for c in str(text))


def text_table(head: list, rows: list) -> str:
    """Columns side by side, a line each row."""
    widths = [max(len(str(r[k])) for r in [head] + rows) for k in range(len(head))]
    return "\n".join("  ".join(str(v).ljust(w) for v, w in zip(r, widths)).rstrip() for r in [head] + rows) + "\n"
