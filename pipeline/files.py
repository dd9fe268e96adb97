"""Files that appear whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from tempfile import NamedTemporaryFile


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A fresh file beside `path` to write to; it replaces `path` in one step when the block ends well.

    Else, on a full disk for example, what was there stays, and nothing is left behind. A device or a pipe is written
    to itself. Raises OSError.
    """
    if path.exists() and not path.is_file():
        yield path
        return
    path = path.resolve()  # a link stays a link
    fresh = path.with_name(f".{path.name}.{os.getpid()}.new")
    try:
        yield fresh
        sync(fresh)
        fresh.replace(path)
    finally:
        with suppress(OSError):
            fresh.unlink(missing_ok=True)


def check_writable(path: Path) -> None:
    """Find out whether `replacing` could write to `path`, as far as that is known before. Raises OSError."""
    if path.exists() and not path.is_file():
        with path.open("ab") if path.is_dir() or path.is_char_device() else nullcontext():
            return  # a pipe would wait for its reader
    path = path.resolve()
    with NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}."):
        pass


def sync(path: Path) -> None:
    """Flush a file or folder to the disk, so that a rename never overtakes the data."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
