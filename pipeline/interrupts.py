"""SIGINT and SIGTERM, also while an FMU's log message calls Python back, where an exception would be lost.

There the signal is kept: kernels look at STOP, and whoever called the FMU raises what was kept with `raise_kept`.
"""

from __future__ import annotations

import signal
from ctypes import c_double
from pathlib import Path
from types import FrameType

CALLED_BACK = {str(Path(__file__).parent / "plant" / name) for name in ("log.py", "fmi3.py")}
"""Files whose functions FMUs call; their other functions do no harm by keeping a signal until the call is over."""

STOP = (c_double * 1)()
"""Not 0 while a signal is kept: kernels that run long end at the next sample."""

_kept: list[BaseException] = []


def install() -> None:
    """Let SIGINT raise KeyboardInterrupt, SIGTERM SystemExit(143), so that every folder is removed on the way out."""
    signal.signal(signal.SIGINT, _received)
    signal.signal(signal.SIGTERM, _received)


def raise_kept() -> None:
    """Raise what came while an FMU had called back."""
    if _kept:
        STOP[0] = 0.0
        error = _kept[0]
        _kept.clear()
        raise error


def _received(number: int, frame: FrameType | None) -> None:
    error = KeyboardInterrupt() if number == signal.SIGINT else SystemExit(143)
    if frame is None or frame.f_code.co_filename not in CALLED_BACK:
        raise error
    _kept.append(error)
    STOP[0] = 1.0
