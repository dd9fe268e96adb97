"""Mistakes in bindings and controllers are found before a step is simulated, and named."""

import pytest

from pipeline.errors import ConfigError
from pipeline.paths import BINDINGS
from pipeline.plant.binding import load_binding
from pipeline.workflow.building import check_fmus
from pipeline.workflow.session import open_session


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("controller.output=['tau_1','tau1']", "controller.output: scara_controller.fmu: no variable `tau1`; nearest"),
        (
            "controller.position=['q_1','tau_2']",
            "`tau_2` of scara_controller.fmu is of causality output; name an input",
        ),
        ("controller.output=['tau_1','q_2']", "`q_2` of scara_controller.fmu is of causality input; name an output"),
        ("controller.start.Kp=3.0", "controller.start: scara_controller.fmu: no variable `Kp`; nearest: Kp"),
    ],
)
def test_a_controllers_ports_are_held_against_its_fmu(fmus, override, message):
    with pytest.raises(ConfigError) as error:
        check_fmus(open_session("scara", [override]))
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('position_start = "q_start_1"', 'position_start = "q_start_2"', "`q_start_2` is bound twice"),
        ('velocity = "qd_1"', 'velocity = "qd_2"', "`qd_2` is bound twice"),
        ("gain = 1.0 ", "gain = 0.0 ", "joint joint 1: gain is 0"),
    ],
)
def test_a_binding_that_says_a_thing_twice_or_nothing_is_refused(tmp_path, old, new, message):
    text = (BINDINGS / "scara.toml").read_text()
    assert old in text
    (tmp_path / "mine.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(ConfigError, match=message):
        load_binding(str(tmp_path / "mine.toml"))


def test_the_controllers_period_is_that_of_the_data():
    with pytest.raises(ConfigError, match=r"controller\.period is 0\.02 s, but the data come every 0\.01 s"):
        open_session("scara", ["controller.period=0.02"])


def test_a_case_without_a_tuning_is_refused():
    with pytest.raises(ConfigError, match=r"length >= 1.*`ekf\.case\[0\]\.tunings`, which is \[\]"):
        open_session("scara", ["ekf.case.0.tunings=[]"])


def test_a_negative_inertia_is_named_as_such(fmus, tmp_path):
    from pipeline.plant.linearisation import linear_plant
    from pipeline.plant.plant import open_plant

    text = (BINDINGS / "scara.toml").read_text().replace("a_priori = 3.42", "a_priori = -3.42")
    (tmp_path / "mine.toml").write_text(text.replace('fmu = "scara.fmu"', f'fmu = "{fmus / "scara.fmu"}"'))
    with (
        open_plant(load_binding(str(tmp_path / "mine.toml")), "linearise") as plant,
        pytest.raises(ConfigError, match="mass matrix at the a-priori values is not positive definite"),
    ):
        linear_plant(plant, plant.binding.a_priori[:2] * 0.0)
