"""The probed regressor against the paper's closed form, and the structures that must be refused."""

from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.errors import IdentificationError
from pipeline.plant.binding import load_binding
from pipeline.plant.plant import open_plant
from pipeline.plant.probing import probe
from tests.closed_form import NAMES, TRUTH, regressor

RNG = np.random.default_rng(1)
Q, QD, QDD = RNG.uniform(-2, 2, (300, 2)), RNG.uniform(-4, 4, (300, 2)), RNG.uniform(-20, 20, (300, 2))


def test_the_probed_regressor_is_the_closed_form(fmus):
    with open_plant(load_binding(str(fmus / "scara.toml")), "probe") as plant:
        model = probe(plant, Q, QD, QDD)
        D, y0 = model(Q, QD, QDD)
    expected = regressor(Q, QD, QDD)
    assert model.names == NAMES and not model.held
    assert np.max(np.abs(D - expected)) <= 1e-9 * np.max(np.abs(expected))
    assert np.max(np.abs(y0)) <= 1e-9 * np.max(np.abs(expected))


def test_a_mass_matrix_that_is_no_mass_is_seen(fmus):
    with open_plant(load_binding(str(fmus / "scara.toml")), "probe") as plant:
        model = probe(plant, Q, QD, QDD)
        assert model.mass_is_positive(Q, QD, TRUTH)
        assert not model.mass_is_positive(Q, QD, -TRUTH), "the force's sign is wrong"
        beyond = TRUTH.copy()
        beyond[4] = 1.1 * np.sqrt(TRUTH[0] * TRUTH[3])
        assert not model.mass_is_positive(Q, QD, beyond), "LMX2² > ZZR1·ZZ2: negative in some poses"
        assert not model.mass_is_positive(Q, QD, 0.0 * TRUTH)


def test_smooth_friction_is_another_regressor(fmus):
    """What `[probe]` is for: probed with the filter's friction, the columns of Fs differ from sign()."""
    slow = 0.02 * QD / 4
    with open_plant(load_binding(str(fmus / "scara.toml")), "filter") as plant:
        D, _ = probe(plant, Q, slow, QDD)(Q, slow, QDD)
    np.testing.assert_allclose(D, regressor(Q, slow, QDD, eps=0.01), atol=1e-9 * np.max(np.abs(D)))
    assert np.max(np.abs(D - regressor(Q, slow, QDD))) > 0.5


class OneJoint:
    """m qdd = u − force(chi, q, qd): a plant whose structure a test chooses."""

    n, compiled = 1, False

    def __init__(self, force, names, mass=lambda chi: 2.0, drive=lambda u: u):
        self.force, self.mass, self.drive = force, mass, drive
        self.file = SimpleNamespace(path=SimpleNamespace(name="joint.fmu"))
        self.binding = SimpleNamespace(
            names=names,
            gain=np.ones(1),
            u_range=np.array([10.0]),
            a_priori=np.ones(len(names)),
            scale=np.ones(len(names)),
        )

    def accelerations(self, q, qd, u, chi):
        return (self.drive(u) - self.force(chi, q, qd)) / self.mass(chi)


ONE = [x[:, :1] for x in (Q, QD, QDD)]


def test_what_is_not_identified_goes_into_y0():
    plant = OneJoint(lambda chi, q, qd: chi[0] * qd + 9.81 * np.sin(q), ("c",))
    D, y0 = probe(plant, *ONE)(*ONE)
    np.testing.assert_allclose(D[:, :, 0], ONE[1], atol=1e-9)
    np.testing.assert_allclose(y0, 2.0 * ONE[2] + 9.81 * np.sin(ONE[0]), atol=1e-9)


def test_a_parameter_that_is_not_linear_alone_is_held_and_named():
    plant = OneJoint(lambda chi, q, qd: chi[0] * qd + np.exp(chi[1]) * q, ("c", "k"))
    model = probe(plant, *ONE)
    assert model.names == ("c",) and list(model.held) == ["k"]
    D, y0 = model(*ONE)
    np.testing.assert_allclose(y0, 2.0 * ONE[2] + np.e * ONE[0], atol=1e-8)
    assert D.shape == (300, 1, 1)


def test_a_set_that_is_not_linear_together_is_refused():
    plant = OneJoint(lambda chi, q, qd: chi[0] * chi[1] * np.sin(q), ("m", "l"))
    with pytest.raises(IdentificationError, match="not linear in its parameters together"):
        probe(plant, *ONE)


def test_saturation_inside_the_range_is_refused():
    plant = OneJoint(lambda chi, q, qd: chi[0] * qd, ("c",), drive=lambda u: np.clip(u, -1.5, 1.5))
    with pytest.raises(IdentificationError, match="not affine in the input"):
        probe(plant, *ONE)
