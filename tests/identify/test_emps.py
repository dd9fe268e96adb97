"""WLS on the EMPS drive, measured: the published result with the published chain, and a better alignment."""

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from pipeline.assess.residuals import residual_tests
from pipeline.assess.validation import predict
from pipeline.identify.covariance import formal
from pipeline.identify.regression import excitation, regression, weighted
from pipeline.identify.rls import rls
from pipeline.identify.wls import solve, wls
from pipeline.settings import Filter, WlsSettings
from pipeline.signals.frames import filter_frame

NAMES, UNITS = ("M", "Fv", "Fc", "offset"), ("kg", "N.s/m", "N", "N")
PUBLISHED = np.array([95.1089, 203.5034, 20.3935, -3.1648])
PUBLISHED_STD = np.array([0.1085, 1.1460, 0.1012, 0.0444])
RATE = 1000.0
CHAIN = {"position": Filter("zero-phase", 100.0), "parallel": Filter("decimate"), "decimation": 10}
PUBLISHED_CHAIN = WlsSettings("WLS(published)", border=(49, 0), half_sample=False, **CHAIN)
HOUSE = WlsSettings("WLS(house)", border=(49, 49), half_sample=True, **CHAIN)


def inverse_model(q, qd, qdd):
    return np.stack([qdd, qd, np.sign(qd), np.ones_like(q)], axis=2), np.zeros_like(q)


def system(folder, name, settings):
    m = {key: np.ravel(value) for key, value in loadmat(folder / name).items() if not key.startswith("__")}
    columns = {"q_1": m["qm"], "u_1": m["vir"], "tau_1": m["gtau"] * m["vir"]}
    frame = pd.DataFrame(columns, index=pd.Index(m["t"], name="time"))
    return regression(filter_frame(frame, 1, RATE, settings), 1, RATE, settings, inverse_model, NAMES)


def errors(folder, settings):
    identification, validation = (system(folder, f, settings) for f in ("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"))
    found = wls(identification, settings.name, UNITS)
    return found, *(predict(s, found.theta).errors["total"] for s in (identification, validation))


def test_the_published_chain_gives_the_published_result(emps_data):
    found, identification, validation = errors(emps_data, PUBLISHED_CHAIN)
    assert found.theta[:3] == pytest.approx(PUBLISHED[:3], rel=0.003)
    assert found.theta[3] == pytest.approx(PUBLISHED[3], rel=0.006)
    assert found.condition_number == pytest.approx(26.0, abs=0.1)
    assert identification == pytest.approx(4.13, abs=0.03)
    assert validation == pytest.approx(6.00, abs=0.03)


def test_the_formal_sigma_is_the_published_one_and_far_too_small(emps_data):
    """Rows 10 ms apart are not independent: the published standard deviations take them to be."""
    published = system(emps_data, "DATA_EMPS.mat", PUBLISHED_CHAIN)
    found = wls(published, "WLS(published)", UNITS)
    _, R = solve(*weighted(published))
    assert np.sqrt(np.diag(formal(R))) == pytest.approx(PUBLISHED_STD, rel=0.1)
    assert (found.sigma > 2 * PUBLISHED_STD).all()
    assert "coloured" in found.sigma_reason


def test_half_sample_alignment_predicts_better(emps_data):
    found, _, validation = errors(emps_data, HOUSE)
    assert validation <= 4.7
    assert found.theta == pytest.approx(PUBLISHED, rel=0.03)


def test_one_joint_runs_through_everything_else(emps_data):
    identification = system(emps_data, "DATA_EMPS.mat", HOUSE)
    found = wls(identification, "WLS(house)", UNITS)
    recursive = rls(identification, UNITS)
    np.testing.assert_allclose(recursive.theta, found.theta, atol=1e-9 * found.sigma.min())
    assert excitation(identification, PUBLISHED).condition_number_Phi == pytest.approx(12.3, abs=0.1)
    (tested,) = residual_tests(identification, found.theta, "N")
    assert not tested.whiteness.ok and tested.rms == pytest.approx(identification.sigma_rho[0], rel=0.01)
