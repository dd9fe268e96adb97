"""The directional derivatives of an FMU at the point where its instance stands."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import byref, c_double, c_uint
from dataclasses import dataclass

import numpy as np

from pipeline.plant.fmu import NOT_FINITE, Instance
from pipeline.plant.references import double_p


@dataclass(frozen=True)
class Sensitivity:
    """A transition and its derivatives: f (ns,); A (ns, ns) by the state; C (ns, n) by the input; B (ns, k) by those
    parameters that are inputs of the FMU, whose places in chi are `fed` (k,)."""

    f: np.ndarray
    A: np.ndarray
    C: np.ndarray
    B: np.ndarray
    fed: np.ndarray


class Tangents:
    """∂unknowns/∂knowns of an instance, one directional derivative per known (2.0.5, §2.1.9; 3.0.2, §2.2.11).

    unknowns, knowns: variable names; the knowns must be states, or inputs (parameters are none after initialisation).
    """

    def __init__(self, instance: Instance, unknowns: Sequence[str], knowns: Sequence[str]):
        self.knowns, self._instance = tuple(knowns), instance
        reference = instance.file.reference
        self._unknowns = (c_uint * len(unknowns))(*[reference(name) for name in unknowns])
        self._knowns = [byref(c_uint(reference(name))) for name in knowns]
        self._seed = byref(c_double(1.0))
        self._columns = np.empty((len(knowns), len(unknowns)))
        self._rows = [row.ctypes.data_as(double_p) for row in self._columns]

    def __call__(self, t: float) -> np.ndarray:
        """The matrix (unknowns, knowns) here and now, t (s) for the message of an FmuError."""
        directional, n = self._instance.calls.directional, len(self._unknowns)
        for known, row in zip(self._knowns, self._rows, strict=True):
            status = directional(self._unknowns, n, known, 1, self._seed, row)
            if status:
                self._instance.check(status, "GetDirectionalDerivative", t)
        if not np.isfinite(self._columns.sum()):
            self._instance.check(NOT_FINITE, "GetDirectionalDerivative", t)
        return self._columns.T.copy()
