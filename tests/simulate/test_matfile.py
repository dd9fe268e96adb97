"""The MAT v5 reader: equal to SciPy's on whole files, and an error, never a crash, on damaged ones."""

import struct
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy.io import loadmat, savemat
from scipy.sparse import csc_array

from pipeline.simulate.matfile import MatError, NotNumbers, read_variables

TYPES = ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "bool"]
on_one_file = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
numeric = st.sampled_from(TYPES).flatmap(
    lambda t: arrays.arrays(t, arrays.array_shapes(min_dims=2, max_dims=3, min_side=0, max_side=5))
)
GOOD = {"t": np.arange(20) / 100.0, "x": np.zeros((20, 1)), "y": np.arange(3, dtype="u1")}


@on_one_file
@given(
    variables=st.dictionaries(st.from_regex(r"[a-z][a-z0-9_]{0,30}", fullmatch=True), numeric, min_size=1, max_size=4),
    compressed=st.booleans(),
)
def test_numeric_variables_equal_scipys(tmp_path, variables, compressed):
    savemat(tmp_path / "a.mat", variables, do_compression=compressed)
    found, expected = read_variables(tmp_path / "a.mat"), loadmat(tmp_path / "a.mat")
    assert set(found) == set(variables)
    for name, values in found.items():
        assert values.shape == expected[name].shape
        np.testing.assert_array_equal(values, expected[name])


def test_what_is_not_numbers_is_said(tmp_path):
    others = {"text": "abc", "s": {"a": 1.0}, "c": np.array([[1, "a"]], dtype=object), "z": np.ones(3) * 1j}
    savemat(tmp_path / "a.mat", {**others, "sparse": csc_array(np.eye(3)), "x": np.ones(2)})
    found = read_variables(tmp_path / "a.mat")
    kinds = {name: value.kind for name, value in found.items() if isinstance(value, NotNumbers)}
    assert kinds == {
        "text": "text",
        "s": "a structure",
        "c": "cells",
        "z": "complex numbers",
        "sparse": "a sparse matrix",
    }


def test_a_big_endian_file_is_read(tmp_path):
    values, name = np.array([1.5, -2.0], ">f8").tobytes(), b"x".ljust(8, b"\0")
    body = struct.pack(">IIII", 6, 8, 6, 0) + struct.pack(">IIii", 5, 8, 2, 1)
    body += struct.pack(">II", 1, 1) + name + struct.pack(">II", 9, len(values)) + values
    header = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x01\x00MI"
    (tmp_path / "a.mat").write_bytes(header + struct.pack(">II", 14, len(body)) + body)
    np.testing.assert_array_equal(read_variables(tmp_path / "a.mat")["x"], [[1.5], [-2.0]])


def test_a_variable_that_stands_twice_is_refused(tmp_path):
    savemat(tmp_path / "a.mat", {"x": np.ones(3)})
    whole = (tmp_path / "a.mat").read_bytes()
    (tmp_path / "a.mat").write_bytes(whole + whole[128:])
    with pytest.raises(MatError, match="`x` stands in it twice"):
        read_variables(tmp_path / "a.mat")


@pytest.mark.parametrize("compressed", [False, True])
def test_every_truncation_loses_a_variable_or_is_refused(tmp_path, compressed):
    savemat(tmp_path / "whole.mat", GOOD, do_compression=compressed)
    whole = (tmp_path / "whole.mat").read_bytes()
    for length in range(1, len(whole) - 8, 7):
        (tmp_path / "a.mat").write_bytes(whole[:length])
        with suppress(MatError):
            assert set(read_variables(tmp_path / "a.mat")) < set(GOOD)


@on_one_file
@given(
    damage=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), min_size=1, max_size=4),
    compressed=st.booleans(),
)
def test_damaged_bytes_are_read_or_refused_in_one_line(tmp_path, damage, compressed):
    savemat(tmp_path / "a.mat", GOOD, do_compression=compressed)
    content = bytearray((tmp_path / "a.mat").read_bytes())
    for place, byte in damage:
        content[place % len(content)] = byte
    (tmp_path / "a.mat").write_bytes(content)
    try:
        read_variables(tmp_path / "a.mat")
    except MatError as error:
        assert len(str(error).splitlines()) == 1
