"""The regression: rows, sigma_rho, condition numbers, rank; against NumPy's own least squares."""

import msgspec
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import DataError, IdentificationError
from pipeline.identify.regression import (
    condition_Phi,
    excitation,
    ols_sigma_rho,
    regression,
    require_full_rank,
    subset,
    weighted,
)
from pipeline.settings import Filter, WlsSettings
from pipeline.signals.frames import filter_frame
from tests.closed_form import NAMES, TRUTH, inverse_model
from tests.reference_loop import RATE, WLS_3, records

RAW = WlsSettings("raw", Filter("none"), Filter("none"), 1)


def filtered_frame(N=200, seed=0):
    rng = np.random.default_rng(seed)
    q, qd, qdd = rng.standard_normal((3, N, 2))
    tau = np.einsum("kip,p->ki", inverse_model(q, qd, qdd)[0], TRUTH)
    columns = {f"{c}_{i + 1}": x[:, i] for c, x in (("q", q), ("qd", qd), ("qdd", qdd), ("tau", tau)) for i in range(2)}
    return pd.DataFrame(columns, index=np.arange(N) / RATE)


def random_system(seed, p=4, rows=60):
    rng = np.random.default_rng(seed)
    W, joint = rng.standard_normal((2 * rows, p)), np.repeat([0, 1], rows)
    W[:rows, -1] = 0.0
    return W, W @ rng.standard_normal(p) + rng.standard_normal(2 * rows) * np.where(joint, 0.1, 2.0), joint


def test_rows_are_sorted_by_joint_and_satisfy_the_model():
    frame = filtered_frame()
    system = regression(frame, 2, RATE, RAW, inverse_model, NAMES)
    np.testing.assert_array_equal(system.joint, np.repeat([0, 1], 200))
    np.testing.assert_array_equal(system.time, np.tile(frame.index, 2))
    np.testing.assert_array_equal(system.y, np.concatenate([frame["tau_1"], frame["tau_2"]]))
    np.testing.assert_allclose(system.W @ TRUTH, system.y, atol=1e-12)


def test_the_part_that_is_not_identified_is_taken_off_y():
    def with_gravity(q, qd, qdd):
        return inverse_model(q, qd, qdd)[0], 9.81 * np.cos(q)

    frame = filtered_frame()
    without = regression(frame, 2, RATE, RAW, inverse_model, NAMES)
    for i in (1, 2):
        frame[f"tau_{i}"] += 9.81 * np.cos(frame[f"q_{i}"])
    np.testing.assert_allclose(regression(frame, 2, RATE, RAW, with_gravity, NAMES).y, without.y, atol=1e-12)


def test_decimated_rows_carry_their_time():
    settings_ = msgspec.structs.replace(WLS_3, border=(30, 40))
    system = regression(filtered_frame(), 2, RATE, settings_, inverse_model, NAMES)
    np.testing.assert_allclose(system.time[:3], [0.30, 0.40, 0.50])
    assert len(system.y) == 2 * 13 and system.decimation == 10


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_sigma_rho_is_that_of_numpys_least_squares(seed):
    W, y, joint = random_system(seed)
    for j, sigma in enumerate(ols_sigma_rho(W, y, joint)):
        rows = joint == j
        chi, _, rank, _ = np.linalg.lstsq(W[rows], y[rows])
        expected = np.linalg.norm(y[rows] - W[rows] @ chi) / np.sqrt(rows.sum() - rank)
        assert sigma == pytest.approx(expected, rel=1e-10)


def test_sigma_rho_of_collinear_columns_counts_the_rank():
    W, y, joint = random_system(1)
    assert ols_sigma_rho(np.hstack([W, W[:, :1]]), y, joint) == pytest.approx(ols_sigma_rho(W, y, joint), rel=1e-10)


def test_sigma_rho_takes_rounding_in_a_column_of_zeros_for_no_parameter():
    W, y, joint = random_system(1)
    rounding = np.where(joint[:, None], 1e-15, 1.0) * np.random.default_rng(0).standard_normal((len(y), 1))
    probed = ols_sigma_rho(np.hstack([W, rounding]), y, joint)
    assert probed[1] == pytest.approx(ols_sigma_rho(W, y, joint)[1], rel=1e-10)


def test_sigma_rho_without_noise_is_rounding_but_not_zero():
    system = regression(filtered_frame(), 2, RATE, RAW, inverse_model, NAMES)
    assert (system.sigma_rho > 0).all() and (system.sigma_rho < 1e-12).all()


def test_weighting_makes_the_residuals_of_the_joints_alike():
    system = regression(filter_frame(records("disturbed")[0], 2, RATE, WLS_3), 2, RATE, WLS_3, inverse_model, NAMES)
    W_w, y_w = weighted(system)
    rho = y_w - W_w @ np.linalg.lstsq(W_w, y_w)[0]
    assert [rho[system.joint == j].std() for j in (0, 1)] == pytest.approx([1, 1], abs=0.05)


def test_condition_numbers_leave_out_what_is_zero_a_priori():
    W, _, _ = random_system(2)
    cond, left_out = condition_Phi(W, np.array([2.0, 0.0, 1.0, 0.5]), ("a", "b", "c", "d"))
    assert left_out == ("b",)
    assert cond == pytest.approx(np.linalg.cond(W[:, [0, 2, 3]] * [2.0, 1.0, 0.5]))
    assert condition_Phi(W, np.zeros(4), ("a", "b", "c", "d")) == (None, ("a", "b", "c", "d"))


def test_excitation_holds_the_singular_values_of_the_weighted_matrix():
    system = regression(filter_frame(records("disturbed")[0], 2, RATE, WLS_3), 2, RATE, WLS_3, inverse_model, NAMES)
    found = excitation(system, TRUTH)
    W_w, _ = weighted(system)
    np.testing.assert_allclose(found.singular_values**2, np.linalg.eigvalsh(W_w.T @ W_w)[::-1], rtol=1e-6)
    assert found.condition_number_W == pytest.approx(found.singular_values[0] / found.singular_values[-1])
    assert found.left_out_of_Phi == ("LMY2",)
    assert 50 < found.condition_number_Phi < 300


def test_subset_keeps_rows_and_weighs_anew():
    W, y, joint = random_system(3)
    names = ("a", "b", "c", "d")
    full = regression(filtered_frame(), 2, RATE, RAW, inverse_model, NAMES)
    part = subset(full, ("ZZR1", "Fs2"))
    np.testing.assert_array_equal(part.W, full.W[:, [0, 7]])
    assert part.names == ("ZZR1", "Fs2") and (part.sigma_rho > full.sigma_rho).all()
    require_full_rank(W, names)


def test_a_silent_parameter_is_named():
    frame = filtered_frame()
    for c in ("qd_2", "qdd_2", "q_2"):
        frame[c] = 0.0
    system = regression(frame, 2, RATE, RAW, inverse_model, NAMES)
    with pytest.raises(IdentificationError, match="not excited: Fv2, Fs2"):
        require_full_rank(weighted(system)[0], NAMES)


def test_parameters_that_cannot_be_told_apart_are_named():
    W, _, _ = random_system(4)
    W = np.hstack([W, W[:, [0]] - 3 * W[:, [2]]])
    with pytest.raises(IdentificationError, match=r"apart: a, c, e \(rank 4 of 5\)"):
        require_full_rank(W, ("a", "b", "c", "d", "e"))


def test_too_few_rows_a_dead_torque_and_wrong_names_are_refused():
    frame = filtered_frame(5)
    with pytest.raises(IdentificationError, match="joint 1: 5 rows for 5"):
        regression(frame, 2, RATE, RAW, inverse_model, NAMES)
    dead = filtered_frame().assign(tau_2=0.0)
    with pytest.raises(IdentificationError, match="joint 2: the torque is 0"):
        regression(dead, 2, RATE, RAW, inverse_model, NAMES)
    with pytest.raises(DataError, match="check the names"):
        regression(filtered_frame(), 2, RATE, RAW, inverse_model, NAMES[:-1])
