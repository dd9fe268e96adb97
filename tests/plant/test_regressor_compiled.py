"""The compiled regressor: the bits of Python's, and the same word on what goes wrong."""

from ctypes import CFUNCTYPE, POINTER, c_double, c_int, c_size_t, c_void_p, cast

import numpy as np
import pytest
from msgspec import structs

from pipeline.errors import FmuError, IdentificationError
from pipeline.in_order import solve
from pipeline.plant import regressor_kernel
from pipeline.plant.binding import load_binding
from pipeline.plant.plant import open_plant
from pipeline.plant.probing import InverseModel, probe

pytestmark = pytest.mark.usefixtures("temporary_folders")

ENGINES = ("python", "compiled")
PLANTS = ("scara", "scara_fmi3", "scara_inputs", "scara_inputs_fmi3", "emps", "emps_fmi3", "emps_inputs")


def motion(n, N=300):
    rng = np.random.default_rng(1)
    return [rng.uniform(-size, size, (N, n)) for size in (2.0, 4.0, 20.0)]


def binding_of(fmus, name):
    binding = load_binding(str(fmus / f"{name.removesuffix('_fmi3')}.toml"))
    return structs.replace(binding, fmu=f"{name}.fmu")


@pytest.mark.parametrize("name", PLANTS)
def test_both_engines_give_the_same_bits(fmus, name):
    binding = binding_of(fmus, name)
    q, qd, qdd = motion(binding.n)
    q.flags.writeable = False  # as pandas gives it
    found = {}
    for engine in ENGINES:
        with open_plant(binding, "probe", engine=engine) as plant:
            model = probe(plant, q, qd, qdd)
            D, y0 = model(q, qd, qdd)
            M = model.mass(q)
            tau = model.torque(q, np.asfortranarray(qd), qdd, 1.1 * binding.a_priori)
            found[engine] = D, y0, tau, M, model.rest(q, qd, M), plant.calls
    for python, compiled in zip(*found.values(), strict=True):
        np.testing.assert_array_equal(compiled, python)


def test_a_mass_for_each_parameter_is_probed_where_nothing_is_known_of_it(fmus):
    """The same regressor to round-off, whether friction is known to leave the mass matrix alone or not."""
    binding = binding_of(fmus, "scara")
    points = motion(2)
    with open_plant(binding, "probe", engine="compiled") as plant:
        known, unknown = probe(plant, *points), InverseModel(plant)
        before = plant.calls
        D, y0 = unknown(*points)
        between = plant.calls
        np.testing.assert_allclose(known(*points)[0], D, atol=1e-12 * np.abs(D).max())
        np.testing.assert_allclose(known(*points)[1], y0, atol=1e-12 * np.abs(D).max())
    assert between - before == 27 * len(points[0])
    assert plant.calls - between == 2 * 19 * len(points[0]), "4 of 8 parameters are friction"


def test_an_fmu_that_refuses_is_named_with_call_time_and_status_and_can_go_on(fmus):
    binding = binding_of(fmus, "scara")
    points = motion(2, 20)
    for engine in ENGINES:
        with open_plant(binding, "probe", engine=engine) as plant:
            model = InverseModel(plant)
            before = model.torque(*points, binding.a_priori)
            with pytest.raises(
                FmuError, match=r"scara\.fmu: fmi2GetDerivatives at t = 0 s returned \w+ .*not a number"
            ):
                model.torque(*points, 0.0 * binding.a_priori)
            np.testing.assert_array_equal(model.torque(*points, binding.a_priori), before)


def replaced(plant, acceleration):
    """Give a compiled plant of two joints a function for its derivatives; returns what must live as long."""

    @CFUNCTYPE(c_int, c_void_p, POINTER(c_double), c_size_t)
    def derivatives(component, dx, n):
        for i in range(n):
            dx[i] = acceleration(i)
        return 0

    plant.memory.set(get_derivatives=cast(derivatives, c_void_p).value)
    return derivatives


def test_derivatives_that_are_no_numbers_and_a_mass_that_is_singular_are_refused(fmus):
    binding = binding_of(fmus, "scara")
    points = motion(2, 5)
    with open_plant(binding, "probe", engine="compiled") as plant:
        kept = replaced(plant, lambda i: np.nan if i == 3 else 1.0)
        with pytest.raises(FmuError, match=r"GetDerivatives at t = 0 s gave a value that is not finite"):
            InverseModel(plant)(*points)
        kept = replaced(plant, lambda i: 1.0)
        with pytest.raises(IdentificationError, match="the mass matrix is singular somewhere on the data"):
            InverseModel(plant)(*points)
        del kept


@pytest.mark.parametrize("n", [1, 2, 5])
def test_elimination_in_order_solves_as_lapack_does_and_in_both_engines_alike(n):
    rng = np.random.default_rng(n)
    A, b = rng.normal(size=(50, n, n)), rng.normal(size=(50, n))
    A[0] = np.eye(n)[::-1]  # a zero where the first pivot would be
    x = solve(A, b)
    np.testing.assert_allclose(x, np.linalg.solve(A, b[..., None])[..., 0], rtol=1e-9)
    for g in range(len(A)):
        compiled = b[g].copy()
        assert regressor_kernel.solve(A[g].copy(), compiled, n)
        np.testing.assert_array_equal(compiled, x[g])
    A[7, n - 1] = 0.0
    with pytest.raises(np.linalg.LinAlgError):
        solve(A, b)
    assert not regressor_kernel.solve(A[7], b[7], n)
