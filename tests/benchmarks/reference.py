"""REF, the dense EKF in C with the plant inlined, compiled into a temporary folder and called by ctypes."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import CDLL, c_int, c_long
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.ctypeslib import ndpointer

from pipeline.export.compiler import find_compiler
from tests.benchmarks.record import Record

FLAGS = ["-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC", "-std=c11"]
HERE = Path(__file__).parent
_array = ndpointer(np.float64, flags="C_CONTIGUOUS")


@dataclass(frozen=True)
class ReferenceRun:
    """What REF found: x (N, nx), the filtered states, and P_diag (N, nx), their variances."""

    x: np.ndarray
    P_diag: np.ndarray


class Reference:
    """REF with one plant compiled in. Use `reference`."""

    def __init__(self, library: Path):
        self._run = CDLL(str(library)).ref_ekf
        self._run.restype, self._run.argtypes = c_long, [c_long, *[_array] * 8, c_int, _array, _array]

    def __call__(self, record: Record, jacobian: str = "forward") -> ReferenceRun:
        """Filter a record; jacobian: "forward" or "central" differences. RuntimeError names the sample of a failure."""
        r, N, nx = record, len(record.time), len(record.z0)
        x, P_diag = np.empty((2, N, nx))
        settings = r.z0, r.P0, r.tuning.R, r.tuning.q, r.scale
        done = self._run(N, r.time, r.q, r.u, *settings, jacobian == "central", x, P_diag)
        if done < N:
            raise RuntimeError(f"REF stopped at sample {done}: the mass matrix or S is not positive definite")
        return ReferenceRun(x, P_diag)


@contextmanager
def reference(plant: str, **sizes: int) -> Iterator[Reference]:
    """REF for the plant of `ref_<plant>.h`; sizes: what that header leaves open, for example LINKS=16."""
    with TemporaryDirectory(prefix="fmuid-ref-") as folder:
        library = Path(folder) / "ref.so"
        defines = [f'-DPLANT="ref_{plant}.h"', *(f"-D{name}={value}" for name, value in sizes.items())]
        command = [*find_compiler(), *FLAGS, *defines, str(HERE / "ref.c"), "-o", str(library), "-lm"]
        subprocess.run(command, check=True)
        yield Reference(library)
