"""Finite differences through a plant against its exact derivatives."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.identify.jacobian import linearise


class Pendulum:
    """A plant with known derivatives: s⁺ = [qd + dt(chi·sin(q) + u), q + dt·qd]."""

    binding = SimpleNamespace(u_range=np.array([2.0]), scale=np.array([1.0]))

    def transition(self, s, u, chi, t, dt):
        return np.array([s[0] + dt * (chi[0] * np.sin(s[1]) + u[0]), s[1] + dt * s[0]])


@pytest.mark.parametrize(("mode", "tolerance"), [("forward", 1e-7), ("central", 1e-10)])
@pytest.mark.parametrize("chi", [0.0, 3.0], ids=["a parameter that is zero", "a parameter that is not"])
def test_against_the_exact_derivatives(mode, tolerance, chi):
    s, u, dt = np.array([0.4, 1.1]), np.array([0.3]), 0.01
    model = linearise(Pendulum(), s, np.array([chi]), u, 0.0, dt, mode)
    np.testing.assert_allclose(model.f, Pendulum().transition(s, u, [chi], 0.0, dt))
    np.testing.assert_allclose(model.A, [[1.0, dt * chi * np.cos(1.1)], [dt, 1.0]], atol=tolerance)
    np.testing.assert_allclose(model.B, [[dt * np.sin(1.1)], [0.0]], atol=1e-6 if mode == "forward" else 1e-8)
    np.testing.assert_allclose(model.C, [[dt], [0.0]], atol=tolerance)
