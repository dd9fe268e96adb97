"""The compiled closed loop: the bits of Python's, and the same word on whatever goes wrong, at the same sample."""

import re

import numpy as np
import pandas as pd
import pytest

from pipeline.errors import FmuError
from pipeline.plant.binding import load_binding
from pipeline.simulate import coupling_compiled
from pipeline.simulate.closed_loop import LoopPorts, simulate_closed_loop, simulate_closed_loop_fmu
from pipeline.simulate.sensors import draw_noise
from tests.plant.moody import MOODS, NAN, build_moody
from tests.simulate.test_closed_loop import EMPS, SCARA

pytestmark = pytest.mark.usefixtures("temporary_folders")

ENGINES = ("python", "compiled")


@pytest.fixture(autouse=True)
def chunks(monkeypatch):
    """Several of them, the last one not whole."""
    monkeypatch.setattr(coupling_compiled, "CHUNK", 17)


def reference(n, period, samples=150):
    t = period * np.arange(samples)
    columns = {f"qr_{i}": 0.2 * i * (1.0 - np.cos(5.0 * t)) for i in range(1, n + 1)}
    columns |= {f"qdr_{i}": 1.0 * i * np.sin(5.0 * t) for i in range(1, n + 1)}
    return pd.DataFrame(columns, index=pd.Index(t, name="time"))


def both(simulate, *arguments, **options):
    python, compiled = (simulate(*arguments, **options, engine=engine) for engine in ENGINES)
    pd.testing.assert_frame_equal(compiled, python, check_exact=True)
    return compiled


@pytest.mark.parametrize("quantum", [(), (1e-3, 0.0)], ids=["exact", "rounding"])
@pytest.mark.parametrize("loop", ["disturbed", "clean"])
@pytest.mark.parametrize("version", ["", "_fmi3"])
def test_two_fmus_give_the_same_bits(fmus, version, loop, quantum):
    given = reference(2, 0.01)
    noise = draw_noise(np.random.default_rng(1), len(given) + 5, [1e-3, 1e-4], [1.0, 0.05], loop, quantum)
    files = fmus / f"scara{version}.fmu", fmus / f"scara_controller{version}.fmu"
    start = {"q_start_1": 0.02, "qd_start_2": 0.5}
    frame = both(simulate_closed_loop, *files, SCARA, given, 0.01, noise, start, {"q_start_1": 0.02}, gain=[2.0, 0.5])
    if quantum:
        steps = frame["q_1"] / 1e-3
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)


def test_a_drive_with_a_pulse_gives_the_same_bits(fmus):
    given = reference(1, 0.001).assign(pulse_1=lambda frame: 5.0 * (frame.index > 0.1))
    gain = load_binding("emps").gains_to_set()
    both(simulate_closed_loop, fmus / "emps.fmu", fmus / "emps_controller.fmu", EMPS, given, 0.001, plant_start=gain)


@pytest.mark.parametrize("version", ["", "_fmi3"])
def test_a_loop_that_is_one_fmu_gives_the_same_bits(fmus, version):
    given = reference(2, 0.01)
    read = [f"{name}_{i}" for name in ("q", "qd", "tau") for i in (1, 2)]
    sampled, held = {name: name for name in read[:4]}, {name: name for name in read[4:]}
    inputs = {name: name for name in given}
    path = fmus / f"scara_closed_loop{version}.fmu"
    frame = both(simulate_closed_loop_fmu, path, inputs, sampled, held, given, 0.01, {"q_start_1": 0.1})
    assert frame["q_1"].iloc[0] == 0.1 and np.abs(frame["qd_1"]).max() > 0.1


@pytest.fixture(scope="module")
def moody(tmp_path_factory):
    return build_moody(tmp_path_factory.mktemp("moody"))


DRIVE = LoopPorts(["u"], ["q"], ["qd"], reference=["u"], position=["x0"], output=["qd"])
AT = 0.25
FAILURES = [
    ("DoStep", 1, r"moody\.fmu: fmi2DoStep at t = 0\.25 s returned Warning \(\w+ is in a mood\)"),
    ("DoStep", 2, r"moody\.fmu: fmi2DoStep at t = 0\.25 s returned Discard \(\w+ is in a mood\)"),
    ("DoStep", 4, r"moody\.fmu: fmi2DoStep at t = 0\.25 s returned Fatal \(\w+ is in a mood\)"),
    ("DoStep", NAN, r"moody\.fmu: `qd` became nan at t = 0\.26 s; check start values, parameters and the step"),
    ("SetReal", 3, r"moody\.fmu: fmi2SetReal at t = 0\.25 s returned Error \(\w+ is in a mood\)"),
]


def words(simulate):
    """What both engines say of a failure, which must be the same."""
    said = []
    for engine in ENGINES:
        with pytest.raises(FmuError) as caught:
            simulate(engine)
        said.append(str(caught.value))
    assert said[0] == said[1] and "\n" not in said[0]
    return said[0]


@pytest.mark.parametrize("side", ["plant_start", "controller_start"])
@pytest.mark.parametrize(("mood", "outcome", "message"), FAILURES)
def test_what_fails_is_named_with_fmu_time_call_and_status(moody, side, mood, outcome, message):
    start = {side: {"mood": MOODS.index(mood), "outcome": outcome, "since": AT - 1e-6, "flood": 30}}
    said = words(lambda e: simulate_closed_loop(moody, moody, DRIVE, reference(1, 0.01), 0.01, engine=e, **start))
    assert re.match(message, said), said


def test_what_is_not_finite_reaches_no_fmu(moody):
    given = reference(1, 0.01)
    given.iloc[33, 0] = np.nan
    said = words(lambda e: simulate_closed_loop(moody, moody, DRIVE, given, 0.01, engine=e))
    assert said.startswith("moody.fmu: `u` is given nan at t = 0.33 s")


@pytest.mark.parametrize("mood", [("DoStep", 2), ("DoStep", NAN), ("SetReal", 3)])
def test_one_fmu_that_fails_is_named_alike(moody, mood):
    start = {"mood": MOODS.index(mood[0]), "outcome": mood[1], "since": AT - 1e-6}
    ports = {"qr_1": "u"}, {"q": "q"}, {"qd": "qd"}
    said = words(lambda e: simulate_closed_loop_fmu(moody, *ports, reference(1, 0.01), 0.01, start, engine=e))
    assert "at t = 0.2" in said


def test_a_step_of_fmi_3_that_fails_says_why(fmus):
    files = fmus / "scara_fmi3.fmu", fmus / "scara_controller_fmi3.fmu"
    massless = {"ZZR1": 0.0, "ZZ2": 0.0, "LMX2": 0.0}
    said = words(
        lambda e: simulate_closed_loop(*files, SCARA, reference(2, 0.01), 0.01, plant_start=massless, engine=e)
    )
    assert said.startswith("scara_fmi3.fmu: fmi3DoStep at t = 0 s returned") and "is not a number" in said
