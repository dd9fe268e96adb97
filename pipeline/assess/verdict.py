"""From checks to one word: pass, warn or fail."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Literal

Status = Literal["pass", "warn", "fail"]
ORDER: tuple[Status, ...] = ("pass", "warn", "fail")


@dataclass(frozen=True)
class Item:
    """One check: what was measured, against what; limit is a bound or a band [low, high]."""

    name: str
    value: float | bool | None
    limit: float | list[float] | bool | None
    status: Status


def at_most(name: str, value: float | None, limit: float, otherwise: Status = "fail") -> Item:
    """value ≤ limit. A value that is missing or not finite fails, whatever `otherwise` is."""
    if not _finite(value):
        return Item(name, None, limit, "fail")
    return Item(name, float(value), limit, "pass" if value <= limit else otherwise)


def at_least(name: str, value: float | None, limit: float, otherwise: Status = "fail") -> Item:
    """value ≥ limit; see `at_most`."""
    if not _finite(value):
        return Item(name, None, limit, "fail")
    return Item(name, float(value), limit, "pass" if value >= limit else otherwise)


def within(name: str, value: float | None, low: float, high: float, otherwise: Status = "fail") -> Item:
    """low ≤ value ≤ high; see `at_most`."""
    if not _finite(value):
        return Item(name, None, [low, high], "fail")
    return Item(name, float(value), [low, high], "pass" if low <= value <= high else otherwise)


def holds(name: str, value: bool, otherwise: Status = "fail") -> Item:
    """A yes-or-no check that should be yes."""
    return Item(name, bool(value), True, "pass" if value else otherwise)


def verdict(items: Iterable[Item]) -> dict:
    """The run record's verdict: the worst status of the items, "warn" where nothing was checked."""
    items = list(items)
    status = max((item.status for item in items), key=ORDER.index, default="warn")
    return {"status": status, "items": [asdict(item) for item in items]}


def _finite(value: float | None) -> bool:
    return value is not None and math.isfinite(value)
