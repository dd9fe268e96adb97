"""A folder to build into: one process at a time, and one line where it cannot be written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pipeline.errors import ExportError

try:
    import fcntl
except ImportError:  # Windows: two processes then build the same twice; each file still appears whole
    fcntl = None


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """Make the folder and keep it to this process; others wait. ExportError where it cannot be written.

    The folder itself is the lock, so that nothing is left to clean up.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with _locked(folder):
            yield
    except OSError as error:
        place, reason = error.filename or folder, error.strerror or error
        raise ExportError(
            f"{place}: cannot be written ({reason}); make room or rights, or name a folder for the FMUs in FMUID_CACHE"
        ) from error


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    if fcntl is None:
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)
