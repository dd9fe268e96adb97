"""Essential parameters: the paper's six in every seed."""

import numpy as np
import pytest

from pipeline.errors import IdentificationError
from pipeline.identify.essential import essential
from pipeline.identify.regression import subset
from pipeline.identify.wls import wls
from tests.closed_form import TRUTH, UNITS
from tests.identify.test_wls import INDEX, system
from tests.reference_loop import CASES, records

SIX = ("ZZR1", "Fs1", "ZZ2", "LMX2", "Fv2", "Fs2")


@pytest.mark.parametrize("case", CASES)
def test_the_papers_six_remain_in_all_seeds(case):
    for frame in records(case)[:20]:
        found = essential(system(frame), UNITS)
        assert found.kept == SIX
        assert {name for name, _ in found.dropped} == {"LMY2", "Fv1"}
        assert all(percent > 20 for _, percent in found.dropped)


def test_the_rest_is_estimated_anew():
    r = system(records("disturbed")[0])
    kept, _, estimate = essential(r, UNITS)
    alone = wls(subset(r, SIX), "six", [UNITS[INDEX[name]] for name in SIX])
    np.testing.assert_array_equal(estimate.theta, alone.theta)
    assert (estimate.relative_sigma_percent <= 20).all()
    assert estimate.theta[0] == pytest.approx(TRUTH[0], rel=0.015)
    assert estimate.units == alone.units


def test_nothing_left_is_an_error():
    with pytest.raises(IdentificationError, match="exceeds 1e-09 %"):
        essential(system(records("disturbed")[0]), UNITS, threshold=1e-9)
