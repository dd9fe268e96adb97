"""RLS: at the end = WLS, on the way = WLS of the rows so far, and a start that is square."""

import numpy as np
import pytest

from pipeline.errors import IdentificationError
from pipeline.identify.regression import weighted
from pipeline.identify.rls import rls, square_start
from pipeline.identify.wls import wls
from tests.closed_form import NAMES, UNITS
from tests.identify.test_wls import system
from tests.reference_loop import CASES, WLS_1, records


@pytest.mark.parametrize("case", CASES)
def test_ends_where_WLS_ends_over_all_seeds(case):
    for frame in records(case)[:20]:
        r = system(frame)
        recursive, batch = rls(r, UNITS), wls(r, "WLS(3)", UNITS)
        assert (np.abs(recursive.theta - batch.theta) < 1e-9 * batch.sigma).all()
        np.testing.assert_allclose(recursive.sigma, batch.sigma, rtol=1e-9)
        np.testing.assert_array_equal(recursive.history[-1], recursive.theta)
        np.testing.assert_allclose(recursive.history_sigma[-1], recursive.sigma, rtol=1e-12)


def test_equals_WLS_on_all_2500_raw_instants_too():
    r = system(records("disturbed")[0], WLS_1)
    batch = wls(r, "WLS(1)", UNITS)
    assert (np.abs(rls(r, UNITS).theta - batch.theta) < 1e-9 * batch.sigma).all()


def test_history_is_the_least_squares_of_the_rows_so_far():
    r = system(records("disturbed")[1])
    found = rls(r, UNITS)
    W_w, y_w = weighted(r)
    for k in (5, 50, len(found.history) - 1):
        rows = r.time <= found.history_time[k]
        np.testing.assert_allclose(found.history[k], np.linalg.lstsq(W_w[rows], y_w[rows])[0], rtol=1e-7)
        information = W_w[rows].T @ W_w[rows]
        np.testing.assert_allclose(found.history_sigma[k], np.sqrt(np.diag(np.linalg.inv(information))), rtol=1e-5)


def test_sigma_only_shrinks_and_time_only_grows():
    found = rls(system(records("disturbed")[2]), UNITS)
    assert (np.diff(found.history_sigma, axis=0) <= 1e-9 * found.history_sigma[:-1]).all()
    assert (np.diff(found.history_time) > 0).all()
    assert found.history.shape == (len(found.history_time), len(NAMES))


def test_the_start_is_extended_until_its_rank_is_full():
    rng = np.random.default_rng(0)
    W = rng.standard_normal((30, 4))
    assert square_start(W) == 4
    W[:10, 3] = 0.0
    assert square_start(W) == 11
    with pytest.raises(IdentificationError, match="10 rows never determine the 4"):
        square_start(np.column_stack([W[:10, :3], 2 * W[:10, 0]]))


def test_joint_sorted_rows_would_not_start():
    r = system(records("disturbed")[0])
    assert np.linalg.matrix_rank(weighted(r)[0][: len(NAMES)]) < len(NAMES)
