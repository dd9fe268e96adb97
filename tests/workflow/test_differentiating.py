"""The filter's Jacobian: what was asked for, checked against another way, and what it gives way to."""

from unittest.mock import patch

import numpy as np
import pytest

from pipeline.errors import FmuError
from pipeline.identify.jacobian import Point
from pipeline.plant.fmu import Fmu
from pipeline.plant.model_exchange import ModelExchangePlant
from pipeline.plant.plant import open_plant
from pipeline.plant.tangents import Tangents
from pipeline.workflow.acquire import simulate
from pipeline.workflow.batch import open_inverse_model, run_variant
from pipeline.workflow.differentiating import JacobianChoice, _compared, choose_jacobian
from pipeline.workflow.session import open_session
from tests.figures.scara import session_of
from tests.plant.moody import build_moody, moody_binding

RK4 = ("ME", "rk4", 4)


@pytest.fixture(scope="module")
def best(fmus):
    """The recommended WLS of a short record."""
    session = session_of()
    frame = simulate(session)
    with open_inverse_model(session, frame) as model:
        return run_variant(session, frame, model, session.recommended)


@pytest.mark.parametrize(("plant", "limit"), [("scara", 3e-5), ("scara_inputs", 1e-5)])  # by parameters: differences
def test_directional_derivatives_are_used_and_agree(best, plant, limit):
    choice = choose_jacobian(open_session("scara", [f"plant={plant!r}"]), best, *RK4)
    assert (choice.used, choice.against, choice.reason, choice.doubt) == ("directional", "central", "", "")
    assert choice.difference < limit


@pytest.mark.parametrize(("mode", "against", "limit"), [("forward", "central", 1e-4), ("central", "forward", 1e-4)])
def test_differences_are_checked_against_each_other(best, mode, against, limit):
    choice = choose_jacobian(open_session("scara", [f"ekf.jacobian={mode!r}"]), best, *RK4)
    assert (choice.used, choice.against, choice.reason) == (mode, against, "")
    assert 0.0 < choice.difference < limit


def test_without_directional_derivatives_differences_are_used(best):
    with patch.object(Fmu, "directional", lambda self, interface: False):
        choice = choose_jacobian(open_session("scara"), best, *RK4)
    assert choice.used == "forward" and "the FMU provides none" in choice.text
    choice = choose_jacobian(open_session("scara"), best, "CS", "rk4", 4)
    assert choice.used == "forward" and "by Co-Simulation there are none of a step" in choice.text


@pytest.mark.parametrize("columns", [slice(0, 2), slice(2, 4), slice(4, 6)], ids=["velocities", "positions", "inputs"])
def test_wrong_directional_derivatives_are_found_and_left_alone(best, columns):
    right = Tangents.__call__

    def wrong(self, t):
        J = right(self, t)
        J[:2, columns] *= 1.01
        return J

    with patch.object(Tangents, "__call__", wrong):
        choice = choose_jacobian(open_session("scara"), best, *RK4)
    assert choice.used == "forward" and "the FMU's directional derivatives are" in choice.reason and not choice.doubt
    assert choice.difference < 1e-4


def test_directional_derivatives_that_fail_are_left_alone(best):
    def fails(self, t):
        raise FmuError("scara.fmu: fmi2GetDirectionalDerivative returned Error")

    with patch.object(Tangents, "__call__", fails):
        choice = choose_jacobian(open_session("scara"), best, *RK4)
    assert choice.used == "forward" and "cannot be had" in choice.reason and "returned Error" in choice.reason


def test_ways_that_disagree_cast_doubt_on_sigma():
    assert "is 2.0e-02 from" in JacobianChoice("forward", "central", 0.02).doubt
    assert JacobianChoice("forward", "central", 1e-6).doubt == ""
    assert "compared with no other" in JacobianChoice("forward", "central", None, "the FMU refused").doubt


def test_points_that_the_plant_refuses_leave_no_trust(best):
    with patch.object(ModelExchangePlant, "transition", side_effect=FmuError("scara.fmu: no mass")):
        choice = choose_jacobian(open_session("scara", ["ekf.jacobian='forward'"]), best, *RK4)
    assert choice.difference is None and "no mass" in choice.reason and choice.doubt


def test_a_wrong_word_on_dependencies_is_found_and_all_columns_differenced(tmp_path):
    """The FMU's acceleration depends on the position, and its description does not say so."""
    points = [Point(np.array([0.3, q]), np.array([2.0, 3.0]), np.array([1.0]), 0.0, 0.01) for q in (0.1, 0.5)]
    honest, wrong = (build_moody(_folder(tmp_path, name), stiffness) for name, stiffness in (("a", 0.0), ("b", 40.0)))
    for engine in ("python", "compiled"):
        with open_plant(moody_binding(honest), engine=engine) as plant:
            choice = _compared(plant, points, "forward")
            assert not choice.all_columns and len(plant.columns) == 4 and not choice.doubt
        with open_plant(moody_binding(wrong), engine=engine) as plant:
            choice = _compared(plant, points, "forward")
        assert choice.all_columns and "all columns are differenced" in choice.text and not choice.doubt


def _folder(parent, name):
    (parent / name).mkdir()
    return parent / name
