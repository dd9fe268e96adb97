"""Finite differences through a plant against its exact derivatives."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.identify.jacobian import Point, disagreement, linearise
from pipeline.plant.tangents import Sensitivity


class Pendulum:
    """A plant with known derivatives: s⁺ = [qd + dt(chi·sin(q) + u), q + dt·qd]."""

    n, ns, compiled, columns = 1, 2, False, range(4)
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


class KnownPendulum(Pendulum):
    """The same plant with exact derivatives by state and input; `fed`: the places of parameters that are inputs too."""

    def __init__(self, fed=(), wrong=0.0):
        self.fed, self.wrong = np.array(fed, int), wrong

    def sensitivity(self, s, u, chi, t, dt):
        A = np.array([[1.0, dt * chi[0] * np.cos(s[1]) + self.wrong], [dt, 1.0]])
        B = np.array([[dt * np.sin(s[1])], [0.0]])[:, self.fed]
        return Sensitivity(self.transition(s, u, chi, t, dt), A, np.array([[dt], [0.0]]), B, self.fed)


@pytest.mark.parametrize(("fed", "tolerance"), [((), 1e-7), ((0,), 1e-16)], ids=["tuned", "an input"])
def test_directional_derivatives_are_taken_where_there_are_any(fed, tolerance):
    s, u, dt = np.array([0.4, 1.1]), np.array([0.3]), 0.01
    model = linearise(KnownPendulum(fed), s, np.array([3.0]), u, 0.0, dt, "directional")
    np.testing.assert_array_equal(model.A, [[1.0, dt * 3.0 * np.cos(1.1)], [dt, 1.0]])
    np.testing.assert_array_equal(model.C, [[dt], [0.0]])
    np.testing.assert_allclose(model.B, [[dt * np.sin(1.1)], [0.0]], rtol=0.0, atol=tolerance)


def test_modes_that_disagree_are_told_apart():
    points = [Point(np.array([0.4, q]), np.array([3.0]), np.array([0.3]), 0.0, 0.01) for q in (-1.0, 0.2, 1.1)]
    assert disagreement(KnownPendulum(), points, "forward", "central") < 1e-6
    assert disagreement(KnownPendulum(), points, "directional", "central") < 1e-6
    wrong = disagreement(KnownPendulum(wrong=0.02), points, "directional", "central")
    assert wrong == pytest.approx(0.02 / 0.01 / (3.0 * np.cos(1.1)), rel=1e-3)  # as rates, where the right one is least
