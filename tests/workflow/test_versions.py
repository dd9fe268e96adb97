"""Every stage of the pipeline on FMUs of either version: the same numbers, to the last bit."""

import numpy as np
import pytest

from pipeline.plant.fmu import open_fmu
from pipeline.workflow.acquire import simulate
from pipeline.workflow.batch import open_inverse_model, run_variant
from pipeline.workflow.filtering import run_case
from pipeline.workflow.provenance import plant_entry
from tests.figures.scara import session_of

SAMPLES = 600


def stages(*overrides):
    """The simulated record, WLS, and the filter on its beginning: (session, frame, theta of WLS, filter run)."""
    session = session_of(1, *overrides)
    frame = simulate(session)
    with open_inverse_model(session, frame) as model:
        best = run_variant(session, frame, model, session.recommended)
    case = next(c for c in session.experiment.ekf.case if c.called("known") == "EKF(3) known")
    return session, frame, best.estimate.theta, run_case(session, frame[:SAMPLES], best, case, "known")


@pytest.fixture(scope="module")
def reference(fmus):
    return stages()


@pytest.mark.parametrize("interface", ["ME", "CS"])
def test_both_versions_give_the_same_bits(reference, interface):
    override = f"ekf.interface={interface!r}"
    _, frame2, theta2, filter2 = reference if interface == "ME" else stages(override)
    session, frame3, theta3, filter3 = stages(override, "fmi='3'")
    with open_fmu(session.binding.path) as file:
        assert file.version == "3.0" and plant_entry(session)["fmi_version"].startswith("3.0")
    np.testing.assert_array_equal(frame3.to_numpy(), frame2.to_numpy())
    np.testing.assert_array_equal(theta3, theta2)
    assert filter3.run.failed_at is None and len(filter3.run.x) == SAMPLES
    np.testing.assert_array_equal(filter3.run.x, filter2.run.x)
    np.testing.assert_array_equal(filter3.run.P, filter2.run.P)
    assert filter3.jacobian == filter2.jacobian


def test_parameters_as_inputs_give_the_same_estimates_but_for_the_differences(reference):
    """The same plant, its parameters inputs: WLS to round-off, the filter to what forward differences leave."""
    _, frame, theta, plain = reference
    _, frame_inputs, theta_inputs, inputs = stages("plant='scara_inputs'")
    np.testing.assert_array_equal(frame_inputs.to_numpy(), frame.to_numpy())
    np.testing.assert_allclose(theta_inputs, theta, rtol=1e-9, atol=1e-9)
    assert inputs.jacobian.used == "directional" and inputs.jacobian.difference < 1e-5
    sigma = np.sqrt(np.diag(plain.run.P))
    assert np.max(np.abs(inputs.run.x[-1] - plain.run.x[-1]) / sigma) < 1e-3
