"""The seam on our FMUs, against the paper's closed form and against itself."""

import msgspec
import numpy as np
import pytest

from pipeline.errors import ConfigError, FmuError
from pipeline.plant.binding import load_binding
from pipeline.plant.fmu import open_fmu
from pipeline.plant.plant import open_plant
from tests.closed_form import TRUTH, acceleration

RNG = np.random.default_rng(0)
POINTS = [(RNG.uniform(-2, 2, 4), RNG.uniform(-1, 1, 2) * [16, 3]) for _ in range(20)]
CHI = TRUTH + np.array([0.3, -0.2, 0.1, 0.01, -0.02, 0.01, 0.01, -0.05])


@pytest.fixture(scope="module", params=["scara.fmu", "scara_fmi3.fmu", "scara_inputs.fmu", "scara_inputs_fmi3.fmu"])
def scara(fmus, request):
    """The plant by both FMI versions, with its parameters as parameters and as inputs."""
    return msgspec.structs.replace(load_binding(str(fmus / "scara.toml")), fmu=request.param)


def exact(s, u, chi):
    return np.concatenate([acceleration(s[2:], s[:2], u, chi, 0.01), s[:2]])


def rk4(s, u, chi, dt, substeps):
    h = dt / substeps
    for _ in range(substeps):
        k1 = exact(s, u, chi)
        k2 = exact(s + h / 2 * k1, u, chi)
        k3 = exact(s + h / 2 * k2, u, chi)
        k4 = exact(s + h * k3, u, chi)
        s = s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return s


def test_derivatives_are_the_closed_form(scara):
    with open_plant(scara) as plant:
        assert (plant.n, plant.ns) == (2, 4)
        for s, u in POINTS:
            for chi in (TRUTH, CHI):
                np.testing.assert_allclose(plant.derivatives(s, u, chi), exact(s, u, chi), rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("substeps", [1, 4])
def test_rk4_transition_is_the_closed_forms(scara, substeps):
    with open_plant(scara, substeps=substeps) as plant:
        for s, u in POINTS:
            np.testing.assert_allclose(
                plant.transition(s, u, CHI, 0.3, 0.002), rk4(s, u, CHI, 0.002, substeps), rtol=1e-11, atol=1e-11
            )


def test_euler_transition_is_equation_13(scara):
    with open_plant(scara, method="euler") as plant:
        for s, u in POINTS:
            expected = s + 0.01 * exact(s, u, CHI)
            np.testing.assert_allclose(plant.transition(s, u, CHI, 0.3, 0.01), expected, rtol=1e-11, atol=1e-11)


def test_co_simulation_and_model_exchange_agree(scara):
    with open_plant(scara, substeps=40) as me, open_plant(scara, interface="CS") as cs:
        for s, u in POINTS:
            a, b = (plant.transition(s, u, CHI, 0.3, 0.01) for plant in (me, cs))
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("engine", ["compiled", "python"])
@pytest.mark.parametrize("interface", ["CS", "CS reset"])
def test_a_binding_makes_the_internal_steps_eulers(scara, interface, engine):
    steps = {**scara.set, "internalStep": 1e-3, "internalOrder": 1}
    binding = msgspec.structs.replace(scara, set=steps)
    with open_plant(scara, method="euler") as me, open_plant(binding, interface=interface, engine=engine) as cs:
        for s, u in POINTS:
            expected = s
            for k in range(10):
                expected = me.transition(expected, u, CHI, 0.3 + k * 1e-3, 1e-3)
            np.testing.assert_allclose(cs.transition(s, u, CHI, 0.3, 0.01), expected, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("interface", ["ME", "CS"])
def test_a_transition_depends_on_its_arguments_alone(scara, interface):
    """Whatever came before, the same arguments give the same bits."""
    with open_plant(scara, interface=interface) as plant:
        first = [plant.transition(s, u, CHI, 0.3, 0.01) for s, u in POINTS]
        for chi in (TRUTH, CHI):
            again = [plant.transition(s, u, chi, 0.1, 0.01) for s, u in reversed(POINTS)][::-1]
        np.testing.assert_array_equal(again, first)


@pytest.mark.parametrize("interface", ["ME", "CS"])
def test_no_mass_is_an_error_that_names_the_fmu(scara, interface):
    with open_plant(scara, interface=interface) as plant:
        with pytest.raises(FmuError, match=scara.fmu):
            plant.transition(np.zeros(4), np.ones(2), np.zeros(8), 0.0, 0.01)
        # and the plant lives on
        s, u = POINTS[0]
        np.testing.assert_allclose(plant.transition(s, u, CHI, 0.0, 0.01)[:2], rk4(s, u, CHI, 0.01, 40)[:2], rtol=1e-2)


def test_accelerations_in_a_batch_are_the_derivatives(scara):
    with open_plant(scara) as plant:
        q, qd = np.array([s[2:] for s, _ in POINTS]), np.array([s[:2] for s, _ in POINTS])
        u = np.array([3.0, 0.5])
        batch = plant.accelerations(q, qd, u, CHI)
        one = [plant.derivatives(s, u, CHI)[:2] for s, _ in POINTS]
        np.testing.assert_array_equal(batch, one)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('input = "tau_1"', 'input = "taul_1"', "no variable `taul_1`; nearest: tau_1"),
        ('input = "tau_1"', 'input = "q_1"', "`q_1` is of causality output there, the binding wants input"),
        (
            'unit = "kg.m2"\na_priori = 3.42',
            'unit = "g.m2"\na_priori = 3.42',
            "the FMU says `kg.m2`, the binding says `g.m2`",
        ),
        ('position_state = "body.q_1"', 'position_state = "q_1"', "`q_1` is no continuous state"),
        ("eps = 1e-9", "epsilon = 1e-9", "no variable `epsilon`; nearest: eps"),
        ('fmu = "scara.fmu"', 'fmu = "scarra.fmu"', "no such FMU"),
    ],
)
def test_a_wrong_binding_is_refused_before_anything_runs(fmus, tmp_path, old, new, message):
    text = (fmus / "scara.toml").read_text()
    assert old in text
    path = tmp_path / "scara.toml"
    path.write_text(text.replace(old, new, 1))
    if "no such FMU" not in message:
        (tmp_path / "scara.fmu").symlink_to(fmus / "scara.fmu")
    with pytest.raises((FmuError, ConfigError)) as error, open_plant(load_binding(str(path))):
        pass
    assert message in str(error.value) and "\n" not in str(error.value)


def test_files_that_are_no_fmu_are_refused_and_leave_nothing(tmp_path):
    for name, content in {"text.fmu": b"not a zip", "empty.fmu": b""}.items():
        path = tmp_path / name
        path.write_bytes(content)
        with pytest.raises(FmuError, match=name):
            open_fmu(path)


def test_folders_are_removed(scara):
    with open_fmu(scara.path) as file:
        folder = file.folder
        assert folder.is_dir()
    assert not folder.exists()


@pytest.mark.parametrize(("method", "substeps"), [("euler", 1), ("rk4", 1), ("rk4", 4)])
def test_sensitivities_are_the_closed_forms(scara, method, substeps):
    """By state, input and parameters that are inputs: against central differences of the exact transition."""

    def exact_transition(z):
        s, u, chi = z[:4], z[4:6], z[6:]
        return s + 0.002 * exact(s, u, chi) if method == "euler" else rk4(s, u, chi, 0.002, substeps)

    with open_plant(scara, method=method, substeps=substeps) as plant:
        for s, u in POINTS:
            found = plant.sensitivity(s, u, CHI, 0.3, 0.002)
            z = np.concatenate([s, u, CHI])
            J = np.array([(exact_transition(z + d) - exact_transition(z - d)) / 2e-6 for d in 1e-6 * np.eye(14)]).T
            assert list(found.fed) == (list(range(8)) if "inputs" in scara.fmu else [])
            np.testing.assert_array_equal(found.f, plant.transition(s, u, CHI, 0.3, 0.002))
            np.testing.assert_allclose(np.hstack([found.A, found.C]), J[:, :6], rtol=1e-7, atol=2e-8)
            if found.fed.size:
                np.testing.assert_allclose(found.B, J[:, 6:], rtol=1e-7, atol=2e-8)


def test_co_simulation_gives_no_directional_derivatives_of_a_step(scara):
    with open_plant(scara, interface="CS") as plant:
        assert not plant.directional
    with open_plant(scara) as plant:
        assert plant.directional
