"""What an expression is read in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import casadi as ca

from pipeline.export.arrays import Value


@dataclass(frozen=True)
class Scope:
    """What an expression is read in: the variables' values by coordinate (kind, index), relation symbols by node,
    the loop variables of a for-family and, inside a function, its values and the functions that are being called.

    quiet: within noEvent() or smooth().
    """

    coordinates: Mapping[tuple[str, int], Value]
    relations: Mapping[int, ca.SX] = field(default_factory=dict)
    binders: Mapping[tuple[int, int], int] = field(default_factory=dict)
    arguments: dict[tuple[str, int], Value] = field(default_factory=dict)
    calls: tuple[int, ...] = ()
    quiet: bool = False
