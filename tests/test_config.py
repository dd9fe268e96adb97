"""Experiments and bindings: what is read, and how each mistake is refused."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.config import apply_override, load_experiment, shipped
from pipeline.errors import ConfigError
from pipeline.paths import BINDINGS
from pipeline.plant.binding import gains_of_bindings, load_binding, variants_of_bindings
from pipeline.settings import Experiment
from pipeline.workflow.session import open_session


@pytest.mark.parametrize("name", ["scara", "emps"])
def test_shipped_experiments_load_and_fit_their_bindings(name):
    session = open_session(name)
    assert name in shipped()
    assert session.experiment.name == name
    assert session.recommended.name == session.experiment.recommended


def test_an_override_reaches_its_place():
    experiment = load_experiment("scara", ["ekf.substeps=8", "wls.WLS(3).decimation=5", "ekf.case.0.method='euler'"])
    assert experiment.ekf.substeps == 8
    assert experiment.wls[2].decimation == 5
    assert experiment.ekf.case[0].method == "euler"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("ekf.substep=8", "unknown key `substep` in `ekf`; did you mean `substeps`?"),
        ("ekf.substeps=0", "Expected `int` >= 1 at `ekf.substeps`"),
        ("ekf.substeps=eight", "Expected `int`, got `str` at `ekf.substeps`"),
        ("ekf.method=heun", 'Invalid enum value \'heun\' at `ekf.method`; give one of "euler", "rk4"'),
        ("ekf.case.0.tunings=['best']", "at `ekf.case[0].tunings[0]`; give one of"),
        ("fmi=3", 'Expected `str`, got `int` at `fmi`; give one of "2", "3"'),
        ("wls.WLS(3).position.knd='none'", "unknown key `knd` in `wls[2].position`; did you mean `kind`?"),
        ("ekf.case.0.chi=[1.0]", "unknown key `chi` in `ekf.case[0]`; did you mean `chi0`?"),
        ("reference.tables.0.titel='x'", "unknown key `titel` in `reference.tables[0]`; did you mean `title`?"),
        ("controler.period=1.0", "unknown key `controler`; did you mean `controller`?"),
        ("closed_loop.xyz=1", "unknown key `xyz` in `closed_loop`; known are estimate, border"),
        ("simulation.truth.ZZR9=1.0", "simulation.truth: no parameter `ZZR9`; nearest: `ZZR1`"),
        ("controller.start.k=stiff", "Expected `float`, got `str` at `controller.start[...]`"),
        ("simulation.sigma_q=0.1", "Expected list, got `float` at `simulation.sigma_q`"),
        ("wls.WLS(4).decimation=5", "nothing is called `WLS(4)` there"),
        ("seed", "want key=value"),
        ("seed=-3", "Expected `int` >= 0 at `seed`"),
        ("recommended=WLS(9)", "recommended `WLS(9)` is none of the WLS variants"),
        ("data.folder='x'", "`data` is missing required field `identification`"),
        ("simulation.sigma_q=[0.001]", "simulation.sigma_q has 1 entries, the plant asks for 2"),
        ("simulation.sigma_q=[0.001, -1]", ">= 0"),
        ("ekf.case.EKF(2).chi0=[1.0]", "EKF(2): chi0 has 1 entries, the plant asks for 8"),
        ("plant=nowhere", "no such binding; known ones are emps, emps_inputs, scara, scara_inputs"),
        ("ekf.recommended='EKF(9)'", "`EKF(9)` is no estimate of this experiment; nearest: `EKF("),
        ("wls.WLS(2).name='WLS(1)'", "two estimates are called `WLS(1)`, or nearly; rename one"),
        ("wls.WLS(2).name='RLS'", "two estimates are called `RLS`, or nearly; rename one"),
        ("wls.WLS(2).name='identification'", "an estimate cannot be called `identification`"),
        ("wls.WLS(2).name='β'", "an estimate cannot be called `β`"),
        ("ekf.case.EKF(3).substeps=8", "2 are called `EKF(3)`; name one by its index, from 0"),
        ("controller.reference=['qr_1']", "controller.reference has 1 entries, the plant asks for 2"),
        ("reference.tables.0.value=[[1.0]]", "give one entry per column and per parameter everywhere"),
    ],
)
def test_each_mistake_is_named(override, message):
    with pytest.raises(ConfigError) as error:
        open_session("scara", [override])
    assert message in str(error.value) and "\n" not in str(error.value)


def test_an_unknown_experiment_and_a_broken_file_are_named(tmp_path):
    with pytest.raises(ConfigError, match="no experiment `scarra`; shipped ones are emps, scara"):
        load_experiment("scarra")
    with pytest.raises(ConfigError, match="no such experiment file"):
        load_experiment(str(tmp_path / "mine.toml"))
    broken = tmp_path / "broken.toml"
    broken.write_text("title = ")
    with pytest.raises(ConfigError, match="not a readable TOML file"):
        load_experiment(str(broken))


keys = st.lists(st.text("abcdef_", min_size=1, max_size=5), min_size=1, max_size=4, unique=True)


@given(keys, st.one_of(st.integers(), st.booleans(), st.floats(allow_nan=False, allow_infinity=False)))
def test_any_scalar_override_reads_as_toml_does(path, value):
    table: dict = {}
    text = repr(value).lower() if isinstance(value, bool) else repr(value)
    apply_override(table, f"{'.'.join(path)}={text}")
    node = table
    for key in path:
        node = node[key]
    assert node == tomllib.loads(f"x = {text}")["x"]


def test_settings_are_frozen():
    experiment = load_experiment("scara")
    assert isinstance(experiment, Experiment)
    with pytest.raises(AttributeError):
        experiment.seed = 3


def test_a_variable_bound_twice_is_refused(tmp_path):
    text = load_binding("scara").path.with_suffix(".toml").read_text()
    path = tmp_path / "twice.toml"
    path.write_text(text.replace('name = "Fs2"', 'name = "Fs2"\nvariable = "Fv2"'))
    with pytest.raises(ConfigError, match="`Fv2` is bound twice"):
        load_binding(str(path))


def test_the_drive_gain_stands_in_the_binding():
    gain = {"G": 35.1507}
    assert gains_of_bindings() == {"emps": gain, "emps_closed_loop": gain, "emps_inputs": gain}


def test_a_binding_extends_another(tmp_path):
    plain, inputs = load_binding("scara"), load_binding("scara_inputs")
    assert inputs.fmu == "scara_inputs.fmu" and inputs.joint == plain.joint and inputs.parameter == plain.parameter
    assert variants_of_bindings()["scara_inputs"] == ("scara", plain.names)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('extends = "none.toml"', "extends `none.toml`, which is no file beside it"),
        ("extends = 3", "extends `3`, which is no file beside it"),
        ('extends = "a.toml"', "extends `a.toml`, which extends another one"),
    ],
)
def test_an_extension_that_leads_nowhere_is_refused(tmp_path, text, message):
    (tmp_path / "a.toml").write_text('extends = "b.toml"')
    (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(ConfigError, match=message):
        load_binding(str(tmp_path / "mine.toml"))


@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
def test_no_setting_is_nan_or_infinite(value):
    with pytest.raises(ConfigError, match=r"`ekf\.case\[3\]\.wls_factor` is -?(nan|inf); give a finite number"):
        load_experiment("scara", [f"ekf.case.3.wls_factor={value}"])


def test_a_record_cannot_validate_itself():
    with pytest.raises(ConfigError, match="the identification record itself"):
        load_experiment("emps", ["data.validation='DATA_EMPS.mat'"])


def test_the_fmi_version_chooses_among_our_fmus_alone(tmp_path):
    def files(experiment, *overrides):
        session = open_session(experiment, overrides)
        return [path.name for path in (session.binding.path, session.controller_fmu)]

    assert files("scara") == ["scara.fmu", "scara_controller.fmu"]
    assert files("scara", "fmi='3'") == ["scara_fmi3.fmu", "scara_controller_fmi3.fmu"]
    (tmp_path / "mine.toml").write_text((BINDINGS / "scara.toml").read_text())
    theirs = [f"plant='{tmp_path / 'mine.toml'}'", "controller.fmu='vendor.fmu'"]
    assert files("scara", "fmi='3'", *theirs) == ["scara.fmu", "vendor.fmu"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("u_range = 16.0", "u_rang = 16.0"), "mine.toml: unknown key `u_rang` in `joint[0]`; did you mean `u_range`?"),
        (("a_priori = 0.07", "apriori = 0.07"), "unknown key `apriori` in `parameter[1]`; did you mean `a_priori`?"),
        (("[probe]", "[prob]"), "unknown key `prob`; did you mean `probe`?"),
        (("eps = 1e-9", 'eps = "small"'), "Expected `float`, got `str` at `probe[...]`"),
    ],
)
def test_a_key_of_a_binding_is_refused_with_the_nearest(tmp_path, change, message):
    text = (BINDINGS / "scara.toml").read_text()
    assert change[0] in text
    (tmp_path / "mine.toml").write_text(text.replace(*change))
    with pytest.raises(ConfigError) as error:
        load_binding(str(tmp_path / "mine.toml"))
    assert message in str(error.value) and "\n" not in str(error.value)
