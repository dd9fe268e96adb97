"""Rows as values: what NumPy computes, to the bit, for every length."""

import numpy as np
import pytest

from pipeline.plant.kernel import kernel
from pipeline.plant.row_kernel import column, row, set_row, symmetric_row, unit_row, without_tiny, zero_row


@kernel
def _compute(records):
    m = records[0]
    total = zero_row(m.A)
    for i in range(m.A.shape[0]):
        if m.b[i] != 0.0:  # from one block of code to the next
            total += m.b[i] * row(m.A, i)
    set_row(m.result, 0, total - row(m.v, 0) / 3.0)
    set_row(m.result, 1, column(m.B, 1) * row(m.v, 0) + 1.0)
    set_row(m.v, 0, row(m.v, 0) - total)
    for i in range(m.S.shape[0]):
        set_row(m.full, i, symmetric_row(m.S, i))
        set_row(m.unit, i, without_tiny(unit_row(row(m.S, i), i), 0.5))


@pytest.mark.parametrize("n", [*range(1, 10), 12, 32])
def test_rows_are_computed_as_numpy_does(n):
    rng = np.random.default_rng(n)
    fields = {"A": (3, n), "B": (n, 2), "b": (3,), "v": (n,), "result": (2, n + 1)}
    fields |= dict.fromkeys(("S", "full", "unit"), (n, n))
    records = np.zeros(1, [(name, "f8", shape) for name, shape in fields.items()])
    m = records[0]
    for name, shape in fields.items():
        m[name] = rng.normal(size=shape)
    m["b"][1] = 0.0
    A, B, b, v, result, S = (m[name].copy() for name in list(fields)[:6])
    _compute(records)
    total = 0.0 + b[0] * A[0] + b[2] * A[2]
    np.testing.assert_array_equal(m["result"][:, :n], [total - v / 3.0, B[:, 1] * v + 1.0])
    np.testing.assert_array_equal(m["result"][:, n], result[:, n])
    np.testing.assert_array_equal(m["v"], v - total)
    np.testing.assert_array_equal(m["full"], np.tril(S) + np.tril(S, -1).T)
    np.testing.assert_array_equal(m["unit"], np.where(np.abs(S) < 0.5, 0.0, np.tril(S, -1)) + np.eye(n))
