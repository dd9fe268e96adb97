"""The engine of an experiment: compiled where it does as Python does, else Python, and it is said why."""

import builtins
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pandas as pd
import pytest

from pipeline.identify import ekf_compiled
from pipeline.plant.probing import InverseModel
from pipeline.simulate import coupling_compiled
from pipeline.workflow.acquire import simulate
from pipeline.workflow.batch import open_inverse_model, run_variant
from pipeline.workflow.differentiating import points_of
from pipeline.workflow.engine import choose_engine, loop_engine, regressor_engine
from pipeline.workflow.filtering import run_case
from pipeline.workflow.session import EngineChoice
from tests.figures.scara import session_of

SAMPLES = 400
RK4 = ("ME", "rk4", 4)


@pytest.fixture(scope="module")
def record(fmus):
    """The measured frame and the recommended WLS."""
    session = session_of()
    frame = simulate(session)
    with open_inverse_model(session, frame) as model:
        return frame, run_variant(session, frame, model, session.recommended)


def filtered(record, name, tuning, *overrides):
    session = session_of(1, *overrides)
    frame, best = record
    case = next(c for c in session.experiment.ekf.case if c.called(tuning) == name)
    return run_case(session, frame[:SAMPLES], best, case, tuning)


@pytest.mark.parametrize("override", ["ekf.jacobian='central'", "ekf.interface='CS reset'", "ekf.covariance='joseph'"])
@pytest.mark.parametrize(
    ("name", "tuning"), [("EKF(1)", "paper"), ("EKF(2)", "paper"), ("EKF(3) known", "known"), ("EKF(3) Euler", "known")]
)
def test_both_engines_give_the_same_estimate(record, name, tuning, override):
    python, compiled = (filtered(record, name, tuning, override, f"engine={e!r}") for e in ("python", "compiled"))
    assert (compiled.engine.used, python.engine.used) == ("compiled", "python")
    assert compiled.estimate.status == python.estimate.status and compiled.estimate.reason == python.estimate.reason
    np.testing.assert_array_equal(compiled.estimate.theta, python.estimate.theta)
    np.testing.assert_array_equal(compiled.run.x, python.run.x)
    np.testing.assert_array_equal(compiled.run.P, python.run.P)
    assert compiled.shift == python.shift and compiled.jacobian == python.jacobian


def test_filterpy_is_an_engine_one_can_select(record):
    exact = "plant='scara_inputs'"  # differences would make 1e-5 to 1e-4 sigma of rounding, all along the record
    engines = ("filterpy", "compiled")
    opinion, ours = (filtered(record, "EKF(3) known", "known", exact, f"engine={e!r}") for e in engines)
    assert opinion.settings["covariance"] == "filterpy" and "filterpy" in opinion.settings["engine"]
    sigma = np.sqrt(np.diag(opinion.run.P))
    assert np.max(np.abs(opinion.run.x[-1] - ours.run.x[-1]) / sigma) < 1e-8


def choice(record):
    session = session_of()
    return choose_engine(session, points_of(session, record[1]), *RK4)


def test_the_compiled_engine_is_the_default(record):
    assert choice(record) == EngineChoice("compiled")


def test_without_numba_it_is_python_and_this_is_said(record):
    real = builtins.__import__

    def without(name, *rest):
        if name.startswith("pipeline.plant.kernel"):
            raise ImportError("No module named 'numba'")
        return real(name, *rest)

    with patch.object(builtins, "__import__", without):
        found = choice(record)
    assert found.used == "python" and "No module named 'numba'" in found.text


def test_with_the_jit_switched_off_it_is_python(record, monkeypatch):
    monkeypatch.setattr("numba.config.DISABLE_JIT", 1)
    assert choice(record).text == "Python (numba cannot be used: NUMBA_DISABLE_JIT is set)"


def test_where_nothing_can_be_compiled_it_is_python(record):
    with patch("pipeline.plant.kernel.compiles", side_effect=RuntimeError("no executable\nmemory")):
        found = choice(record)
    assert found.text == "Python (numba cannot be used: no executable memory)"


def off(field, factor):
    """What the kernel of the filter gets, with one field of its record a little off."""
    right = ekf_compiled._memory

    def wrong(*arguments):
        memory = right(*arguments)
        memory.set(**{field: memory[field] * factor})
        return memory

    return patch.object(ekf_compiled, "_memory", wrong)


@pytest.mark.parametrize("field", ["R", "noise", "z", "epsilon"])
def test_a_compiled_filter_that_is_off_gives_way_to_python(record, field):
    with off(field, 1.1 if field == "epsilon" else 1.0 + 1e-7):
        found = choice(record)
    assert found.used == "python" and found.reason.startswith("compiled, it is")


def test_a_compiled_filter_that_fails_otherwise_gives_way_to_python(record):
    with off("z", -1.0):
        found = choice(record)
    assert found.used == "python" and "ends otherwise" in found.reason and "mass matrix" in found.reason


def test_a_kernel_that_cannot_be_compiled_gives_way_to_python(record):
    with patch.object(ekf_compiled, "run", side_effect=TypeError("cannot unify\nfloat64 and str")):
        found = choice(record)
    assert found == EngineChoice("python", "compiled, it fails: cannot unify float64 and str")


def test_engines_that_could_not_be_compared_are_not_believed(record):
    points = [replace(p, chi=0.0 * p.chi) for p in points_of(session_of(), record[1])]
    found = choose_engine(session_of(), points, *RK4)
    assert found.used == "python" and "could not be compared" in found.reason


def test_what_is_chosen_reaches_the_record_and_the_user(record):
    lines = []
    session = replace(session_of(), narrate=lines.append)
    frame, best = record
    case = session.experiment.ekf.case[-1]
    with patch("pipeline.workflow.engine.unavailable", lambda narrate: "numba cannot be imported: gone"):
        found = run_case(session, frame[:50], best, case, "known")
    assert found.engine.used == "python" and "gone" in found.settings["engine"]
    assert len(lines) == 1 and "Python (numba cannot be imported: gone)" in lines[0]


def test_of_regressor_and_closed_loop_it_is_said_once(record):
    lines = []
    session = replace(session_of(), narrate=lines.append)
    with patch("pipeline.workflow.engine.unavailable", lambda narrate: "numba cannot be used: gone"):
        for _ in range(2):
            with open_inverse_model(session, record[0]):
                pass
            simulate(session)
    assert {part: found.used for part, found in session.engines.items()} == {
        "regressor": "python",
        "closed loop": "python",
    }
    assert lines == [f"  {part}: Python (numba cannot be used: gone)" for part in ("regressor", "closed loop")]


@pytest.mark.parametrize("off", [0.0, 1e-7])
def test_a_regressor_or_a_loop_that_is_off_gives_way_to_python(off):
    rng = np.random.default_rng(0)
    motion = rng.normal(size=(3, 20, 2))
    right = InverseModel.__call__

    def wrong(self, *arguments):
        D, y0 = right(self, *arguments)
        return D * (1.0 + off * self._plant.compiled), y0

    with patch.object(InverseModel, "__call__", wrong):
        assert regressor_engine(session_of(), *motion) == ("python" if off else "compiled")
    beginning = {"python": np.ones((3, 4)), "compiled": np.full((3, 4), 1.0 + off)}
    assert loop_engine(session_of(), lambda engine, samples: beginning[engine][:samples]) == (
        "python" if off else "compiled"
    )


def test_the_loop_is_simulated_by_the_sessions_engine(fmus):
    with patch.object(coupling_compiled, "couple", wraps=coupling_compiled.couple) as kernel:
        python = simulate(session_of(1, "engine='python'"))
        assert not kernel.called
        compiled = simulate(session_of())
        assert kernel.called
    pd.testing.assert_frame_equal(compiled, python, check_exact=True)
