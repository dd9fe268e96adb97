"""Another importer: CasADi's DaeBuilder reads our FMUs of both versions and differentiates them by their own calls."""

import casadi as ca
import numpy as np
import pytest

from tests.export.test_derivatives import jacobian

VERSIONS = ("", "_fmi3")
CONTINUOUS = ("scara", "scara_inputs", "emps", "emps_inputs", "scara_controller_continuous")


@pytest.fixture(params=[(name, version) for name in CONTINUOUS for version in VERSIONS], ids="".join)
def imported(request, archives):
    """(our driver's archive, DaeBuilder's function (x, u) -> (derivatives, outputs), its states, inputs, outputs)."""
    archive = archives("".join(request.param))
    dae = ca.DaeBuilder("M", str(archive.folder), {})
    return archive, dae.create("f", ["x", "u"], ["ode", "y"]), dae.x(), dae.u(), dae.y()


def point(archive, x, u):
    """States and inputs off the start: inputs that are parameters near their values."""
    starts = {v.name: float(v.start) for v in archive.description.modelVariables if v.causality == "input"}
    return 0.1 + 0.07 * np.arange(len(x)), np.array([starts[n] + 0.02 * (i + 1) for i, n in enumerate(u)])


def test_another_importer_sees_the_same_derivatives_outputs_and_jacobians(imported):
    archive, f, x, u, y = imported
    at, by = point(archive, x, u)
    unknown, known = [*archive.derivatives, *y], [*x, *u]
    with archive.model_exchange() as instance:
        instance.set(**dict(zip(u, by, strict=True)))
        dx = instance.rhs(0.0, at)
        assert x == archive.states
        expected, outputs = jacobian(instance, unknown, known), instance.get(*y)
    found = f(at, by)
    assert np.array_equal(found[0].full().ravel(), dx) and np.array_equal(found[1].full().ravel(), outputs)
    blocks = ["jac:ode:x", "jac:ode:u", "jac:y:x", "jac:y:u"]
    A, B, C, D = (block.full() for block in f.factory("J", ["x", "u"], blocks)(at, by))
    assert np.block([[A, B], [C, D]]) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert np.abs(expected).max() > 0.1


def test_its_forward_and_reverse_modes_agree(imported):
    archive, f, x, u, y = imported
    at, by = point(archive, x, u)
    rng = np.random.default_rng(2)
    seeds, weights = (rng.normal(size=(n, 1)) for n in (len(x) + len(u), len(x) + len(y)))
    forward, reverse = f.forward(1), f.reverse(1)
    results = f(at, by)
    tangents = forward(at, by, *results, seeds[: len(x)], seeds[len(x) :])
    gradients = reverse(at, by, *results, weights[: len(x)], weights[len(x) :])
    inner = float(ca.dot(ca.vertcat(*tangents), weights)), float(ca.dot(ca.vertcat(*gradients), seeds))
    assert inner[0] == pytest.approx(inner[1], rel=1e-10) and inner[0] != 0.0
