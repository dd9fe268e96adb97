"""Arrays of CasADi scalars against NumPy."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.export.arrays import elementwise, flatten, index, matmul, size, stack, subscripts, to_int, unflatten

numbers = st.integers(-9, 9)


def nested(array):
    return unflatten((ca.SX(float(item)) for item in np.ravel(array)), list(np.shape(array)))


def numeric(value):
    return np.array([numeric(item) for item in value]) if isinstance(value, tuple) else float(value)


matrices = st.tuples(st.integers(1, 3), st.integers(1, 3)).flatmap(
    lambda shape: st.lists(
        st.lists(numbers, min_size=shape[1], max_size=shape[1]), min_size=shape[0], max_size=shape[0]
    )
)


@given(matrices)
def test_flatten_goes_row_by_row_and_unflatten_back(rows):
    assert [float(item) for item in flatten(nested(rows))] == list(np.ravel(rows))
    assert (numeric(unflatten(iter(flatten(nested(rows))), list(np.shape(rows)))) == rows).all()


@given(matrices)
def test_products_are_those_of_numpy(rows):
    A, v, w = np.array(rows), np.arange(len(rows[0])) - 1.0, np.arange(len(rows)) + 2.0
    assert (numeric(matmul(nested(A), nested(A.T))) == A @ A.T).all()
    assert (numeric(matmul(nested(A), nested(v))) == A @ v).all()
    assert (numeric(matmul(nested(w), nested(A))) == w @ A).all()
    assert numeric(matmul(nested(v), nested(v))) == v @ v


@given(matrices)
def test_concatenation_indexing_and_size(rows):
    A = np.array(rows)
    assert (numeric(stack([nested(A), nested(A)], "1")) == np.vstack([A, A])).all()
    assert (numeric(stack([nested(A), nested(A)], "2")) == np.hstack([A, A])).all()
    assert (numeric(index(nested(A), [slice(None), 0])) == A[:, 0]).all()
    assert (numeric(index(nested(A), [len(A) - 1])) == A[-1]).all()
    assert (size(nested(A), 1), size(nested(A), 2)) == A.shape


def test_a_scalar_goes_with_every_element_and_other_sizes_do_not():
    A = nested([[1, 2], [3, 4]])
    assert (numeric(elementwise(lambda a, b: a + b, A, ca.SX(10))) == [[11, 12], [13, 14]]).all()
    with pytest.raises(ValueError, match="unpack|zip"):
        elementwise(lambda a, b: a + b, nested([1, 2]), nested([1, 2, 3]))


def test_subscripts_are_those_of_modelica():
    assert subscripts([]) == [""] and subscripts([2]) == ["[1]", "[2]"]
    assert subscripts([2, 2]) == ["[1,1]", "[1,2]", "[2,1]", "[2,2]"]


def test_integers_are_constants_without_a_fraction():
    assert to_int(ca.SX(3)) == 3
    assert to_int(ca.SX(2.5)) is None and to_int(ca.SX.sym("x")) is None and to_int((ca.SX(1),)) is None
