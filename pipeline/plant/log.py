"""The log messages of FMU instances. In FMI 2.0 one callback serves all: fmpy's C proxy that formats knows one only."""

from __future__ import annotations

from ctypes import byref
from itertools import count

from fmpy import calloc, free
from fmpy.fmi1 import printLogMessage
from fmpy.fmi2 import (
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.logging import addLoggerProxy

KEPT, LENGTH = 20, 300
_logs: dict[str, list[str]] = {}
_numbers = count(1)


def open_log(model: str) -> tuple[str, list[str]]:
    """A name that no other instance bears, and the list that its last messages will stand in."""
    name = f"{model}-{next(_numbers)}"
    return name, _logs.setdefault(name, [])


def close_log(name: str) -> None:
    """Forget an instance's messages."""
    _logs.pop(name, None)


def keep(log: list[str], message: bytes | None) -> None:
    """Append a message to an instance's log: printable, of limited length, the last ones only."""
    text = (message or b"").decode("utf-8", "replace")
    log[:] = [*log[1 - KEPT :], "".join(c if c.isprintable() else " " for c in text)[:LENGTH]]


def _logged(environment, name, status, category, message) -> None:
    log = _logs.get((name or b"").decode("utf-8", "replace"))
    if log is None:  # an instance that fmpy's own functions made: its messages go where they would have gone
        printLogMessage(environment, name, status, category, message)
    else:
        keep(log, message)


callbacks = fmi2CallbackFunctions()
callbacks.logger = fmi2CallbackLoggerTYPE(_logged)
callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
addLoggerProxy(byref(callbacks))
