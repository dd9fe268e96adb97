"""The promised figures of the SCARA on fewer seeds; `make figures` takes them all."""

import pytest

from tests.figures import scara


@pytest.fixture(scope="module")
def session(fmus):
    return scara.session_of()


def test_excitation_and_regressor(session):
    for row in scara.excitation_figures(session):
        assert row.held, row


def test_two_fmus_are_the_modelica_closed_loop(session):
    row = scara.closed_loop_figure(session)
    assert row.held, row


def test_noise_free_filter_finds_the_truth(session):
    row = scara.noise_free_figure()
    assert row.held, row


def test_covariance_forms_agree_through_the_fmu(session):
    same, directional, own = scara.covariance_figures()
    assert same.held and directional.held, (same, directional)
    assert float(own.measured) < 1e-6, "round-off of the differences alone: 1e-16 over a step of 1e-5"


def test_consistent_filter_on_three_seeds(session):
    rows = scara.ekf_figures(range(1, 4))
    for row in rows[1:]:
        assert row.held, row
    # the mean NIS of three seeds scatters by ±0.03 around that of twenty
    assert 1.9 < float(rows[0].measured) < 2.1


def test_wls_on_three_seeds(session):
    for row in scara.wls_figures("disturbed", range(1, 4)):
        if "claimed/actual" not in row.name and "of the mean" not in row.name:  # statistics over seeds
            assert row.held, row
