"""The planar chain of n links: one source for every n, against the recursion of Newton and Euler."""

import casadi as ca
import numpy as np
import pytest

from pipeline.export.build import build
from pipeline.export.equations import translate
from pipeline.export.frontend import load
from pipeline.paths import FMUS, MODELICA
from pipeline.plant.binding import check_binding
from pipeline.plant.fmu import open_fmu
from tests.benchmarks.chain import a_priori, chain_binding
from tests.closed_form import regressor
from tests.export.driver import Archive
from tests.newton_euler import LENGTH, accelerations, energy, torques

BUILT = (2, 4)
H = 0.01


@pytest.fixture(scope="module")
def chains():
    """{(n, FMI version): the FMU, unpacked}."""
    build([f"chain{n}" for n in BUILT], FMUS)
    opened = {(n, v): Archive(FMUS / f"chain{n}{'_fmi3' * (v == 3)}.fmu") for n in BUILT for v in (2, 3)}
    yield opened
    for archive in opened.values():
        archive.close()


def elements(**arrays):
    """{"q[1]": value, …} of arrays (n,)."""
    return {f"{name}[{i}]": value for name, values in arrays.items() for i, value in enumerate(values, start=1)}


def parameters(n, rng, **others):
    """Those of a robot that is not quite the default one."""
    return {name: values * rng.uniform(0.95, 1.05, n) for name, values in a_priori(n).items()} | others


def points(n, rng, count=20):
    """Random (q, qd, tau, chi): joints anywhere, moving, pushed."""
    for _ in range(count):
        yield rng.uniform(-3, 3, n), rng.uniform(-2, 2, n), rng.uniform(-20, 20, n), parameters(n, rng)


@pytest.mark.parametrize("n", BUILT)
def test_the_fmus_move_as_newton_and_euler_say_in_both_versions_to_the_same_bit(chains, n):
    for q, qd, tau, chi in points(n, np.random.default_rng(n)):
        found = []
        for version in (2, 3):
            with chains[n, version].model_exchange(**elements(tau=tau, **chi)) as instance:
                found.append(instance.rhs(0.0, np.concatenate([q, qd])))
        expected = accelerations(q, qd, tau, chi)
        assert np.array_equal(found[0], found[1]) and np.array_equal(found[0][:n], qd)
        assert np.abs(found[0][n:] - expected).max() <= 1e-11 * np.abs(expected).max()


@pytest.fixture(scope="module")
def translated():
    """`translated(n)`: the model, sorted but not compiled, and its derivatives at (x, tau, values of parameters)."""

    def chain(n):
        model = translate(load(MODELICA, f"RobotIdentification.Benchmarks.Chain{n}"))
        names = [variable.name for kind in ("constant", "parameter") for variable in model.variables[kind]]
        starts = {v.name: v.start for kind in ("constant", "parameter") for v in model.variables[kind]}
        own = model.symbols("constant", "parameter")
        calculated = ca.Function("calculated", [own], [model.calculated])
        f = ca.Function("derivatives", model.arguments(), [model.derivatives])

        def derivatives(x, tau, chi):
            p = ca.DM([chi.get(name, starts[name]) for name in names])
            return f(0, x, tau, ca.vertcat(p, calculated(p)), [], []).full().ravel()

        return f, derivatives

    return chain


@pytest.mark.parametrize("n", [8, 16])
def test_longer_chains_need_the_torques_that_newton_and_euler_say(translated, n):
    _, derivatives = translated(n)
    for q, qd, tau, chi in points(n, np.random.default_rng(n)):
        dx = derivatives(np.concatenate([q, qd]), tau, elements(**chi))
        needed = torques(q, qd, dx[n:], chi)
        still = np.abs(torques(q, qd, 0 * qd, chi)).max()
        assert np.array_equal(dx[:n], qd)
        assert np.abs(needed - tau).max() <= 1e-11 * max(still, np.abs(tau).max())


def test_the_cost_of_an_evaluation_grows_with_the_cube_of_n_at_most(translated):
    operations = {n: translated(n)[0].n_instructions() for n in (4, 8, 16)}
    assert operations[16] <= 16**3 * 1.2
    assert operations[16] / operations[8] < 8 and operations[8] / operations[4] < 8


def test_two_links_without_gravity_are_the_scara(chains):
    rng = np.random.default_rng(0)
    ZZ, MX2, Fv, Fs = np.array([3.42, 0.064]), 0.262, np.array([0.07, 0.015]), np.array([0.58, 0.156])
    closed = np.array([ZZ[0], Fv[0], Fs[0], ZZ[1], LENGTH * MX2, 0.0, Fv[1], Fs[1]])
    values = elements(ZZ=ZZ, MX=[1.0, MX2], Fv=Fv, Fs=Fs) | {"g": 0.0, "eps": 0.02}
    with chains[2, 2].model_exchange(**values) as instance:
        for _ in range(20):
            q, qd, tau = rng.uniform(-2, 2, (3, 2))
            instance.set(**elements(tau=tau))
            qdd = instance.rhs(0.0, np.concatenate([q, qd]))[2:]
            D = regressor(q[None], qd[None], qdd[None], eps=0.02)[0]
            assert D @ closed == pytest.approx(tau, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("n", BUILT)
def test_without_friction_the_energy_stays(chains, n):
    rng = np.random.default_rng(n)
    q, qd = rng.uniform(-1, 1, n), rng.uniform(-1, 1, n)
    chi = parameters(n, rng, Fv=np.zeros(n), Fs=np.zeros(n))
    energies = [energy(q, qd, chi)]
    with chains[n, 2].co_simulation(**elements(q_start=q, qd_start=qd, **chi)) as instance:
        for k in range(100):
            instance.step(k * H, H)
            q, qd = (instance.get(*elements(**{name: range(n)})) for name in ("q", "qd"))
            energies.append(energy(q, qd, chi))
    assert np.abs(qd).max() > 0.1
    assert np.ptp(energies) <= 1e-9 * np.abs(energies).max()


@pytest.mark.parametrize("n", BUILT)
def test_the_directional_derivatives_are_the_differences(chains, n):
    rng, archive = np.random.default_rng(n), chains[n, 2]
    x, dx, step = rng.uniform(-1, 1, 2 * n), rng.uniform(-1, 1, 2 * n), 1e-6
    with archive.model_exchange(**elements(tau=rng.uniform(-9, 9, n))) as instance:
        around = [instance.rhs(0.0, x + sign * step * dx) for sign in (1, -1)]
        instance.rhs(0.0, x)
        found = instance.directional(archive.derivatives, archive.states, dx)
    expected = (around[0] - around[1]) / (2 * step)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("n", BUILT)
def test_the_binding_fits_the_fmu(chains, n, tmp_path):
    chains[n, 2]  # built
    path = tmp_path / f"chain{n}.fmu"
    path.write_bytes((FMUS / path.name).read_bytes())
    binding = chain_binding(n, path)
    with open_fmu(binding.path) as file:
        check_binding(binding, file)
    assert binding.n == n and binding.names[::n] == ("ZZ[1]", "MX[1]", "Fv[1]", "Fs[1]")
    starts = {v.name: float(v.start) for v in chains[n, 2].description.modelVariables if v.name in binding.names}
    assert [starts[name] for name in binding.names] == pytest.approx(list(binding.a_priori), rel=1e-15)
