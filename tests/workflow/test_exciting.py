"""The design of a trajectory through the FMUs: small ones, held to their limits by the closed form."""

import shutil

import numpy as np
import pytest

from pipeline.config import load_experiment
from pipeline.errors import ConfigError, DataError, FmuError, IdentificationError
from pipeline.paths import EXPERIMENTS
from pipeline.simulate.trajectory import Limits, check_limits, sample, waypoints_text
from pipeline.workflow import exciting
from pipeline.workflow.acquire import simulate
from pipeline.workflow.excitation_settings import check_output
from pipeline.workflow.exciting import excite
from pipeline.workflow.session import open_session
from tests.closed_form import TRUTH, inverse_model, regressor

SMALL = ("excitation.starts=2", "excitation.iterations=12", "excitation.segments=8")
SHARP = 1e-9  # rad/s: at rest, rounding gives sgn() a sign
NO_CAPS = ("excitation.condition_number_W=1e6", "excitation.condition_number_Phi=1e6")


def limits_of(name):
    e = load_experiment(name).excitation
    return Limits(e.q, e.qd, e.qdd, e.tau)


@pytest.fixture(scope="module")
def small(fmus):
    return excite(open_session("scara", [*SMALL, *NO_CAPS]))


def test_a_design_keeps_its_limits_everywhere(small):
    check_limits(small.waypoints, limits_of("scara"), lambda q, qd, qdd: inverse_model(q, qd, qdd)[0] @ TRUTH)
    assert small.looped and small.used.shape == (4, 2)
    assert 0.5 < small.used.max() <= 1.0


def test_the_same_seed_gives_the_same_file(small):
    again = excite(open_session("scara", [*SMALL, *NO_CAPS]))
    assert waypoints_text(again.waypoints) == waypoints_text(small.waypoints)
    other = excite(open_session("scara", [*SMALL, *NO_CAPS, "seed=2"]))
    assert waypoints_text(other.waypoints) != waypoints_text(small.waypoints)


def test_what_it_is_worth_is_the_closed_forms(small):
    motion = sample(small.waypoints, 100.0)
    D = regressor(motion.q, motion.qd, motion.qdd, SHARP)
    W = np.vstack([D[:, 0], D[:, 1] / 0.05])
    relative = W * np.where(TRUTH == 0.0, 0.05, TRUTH)
    assert small.log_det == pytest.approx(np.linalg.slogdet(relative.T @ relative)[1], rel=1e-8)
    assert small.excitation.condition_number_W == pytest.approx(np.linalg.cond(W), rel=1e-8)
    assert small.excitation.left_out_of_Phi == ("LMY2",)


def test_a_prismatic_drive_with_measured_data_is_designed_without_them(fmus):
    design = excite(open_session("emps", SMALL))
    assert design.waypoints.unit == "m" and design.used.max() <= 1.0
    check_limits(
        design.waypoints,
        limits_of("emps"),
        lambda q, qd, qdd: 95.0 * qdd + 200.0 * qd + 20.0 * np.sign(qd) - 3.0,
    )


def test_validation_has_segments_of_its_own(fmus):
    session = open_session("scara", [*SMALL, *NO_CAPS, "excitation.validation={segments=5, segment=1.5}"])
    np.testing.assert_allclose(excite(session, validation=True).waypoints.t, 1.5 * np.arange(6))


def test_an_interruption_finishes_the_best_so_far(fmus):
    said = []

    def tell(done, total, best):
        if done == 20 and not said:
            said.append(done)
            raise KeyboardInterrupt

    design = excite(open_session("scara", [*SMALL, *NO_CAPS], said.append), tell=tell)
    assert design.interrupted and design.used.max() <= 1.0
    assert any("interrupted" in str(text) for text in said)


def test_caps_out_of_reach_are_refused_with_what_was_reached(fmus, monkeypatch):
    monkeypatch.setattr(exciting, "ROUNDS", 2)
    tight = ["excitation.condition_number_W=20.0", "excitation.starts=1"]
    with pytest.raises(IdentificationError, match=r"condition_number_W \d+, its cap is 20; widen") as caught:
        excite(open_session("scara", [*SMALL, *tight]))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("excitation.q=[2.4]", "excitation.q has 1 entries, the plant asks for 2"),
        ("excitation.tau=[16.0, -3.0]", "Expected `float` > 0"),
        ("excitation={q=[1.0, 1.0]}", "missing required field"),
        ("excitation.qddd=[1.0, 1.0]", "did you mean `qdd`"),
        ("excitation.sigma_tau=[1.0]", "excitation.sigma_tau has 1 entries"),
        ("excitation.starts=0", "Expected `int` >= 1"),
    ],
)
def test_wrong_settings_are_refused_in_one_line(override, message):
    with pytest.raises(ConfigError, match=message) as caught:
        open_session("scara", [override])
    assert "\n" not in str(caught.value)


def test_an_experiment_without_the_table_says_what_to_add(tmp_path, fmus):
    text = (EXPERIMENTS / "scara.toml").read_text()
    start = text.index("[excitation]")
    (tmp_path / "mine.toml").write_text(text[:start] + text[text.index("[[wls]]", start) :])
    with pytest.raises(ConfigError, match=r"mine: no \[excitation\] to design for; add it with the limits q, qd"):
        excite(open_session(str(tmp_path / "mine.toml")))


def test_a_missing_fmu_is_named(tmp_path, fmus):
    text = (fmus / "scara.toml").read_text().replace('"scara.fmu"', '"none.fmu"')
    (tmp_path / "plant.toml").write_text(text)
    with pytest.raises(FmuError, match="none.fmu: no such FMU"):
        excite(open_session("scara", [f"plant='{tmp_path / 'plant.toml'}'"]))


def test_without_known_noise_or_controller_every_joint_weighs_the_same(tmp_path, fmus):
    """Measured data alone: the plan is checked, and this is said."""
    (tmp_path / "mine.toml").write_text(
        """
title = "Mine"
plant = "scara"
recommended = "WLS"
data = { identification = "a.csv", validation = "b.csv", rate = 100.0, columns = {} }
wls = [{ name = "WLS", position = { kind = "none" }, parallel = { kind = "none" } }]
[excitation]
q = [2.4, 2.4]
qd = [2.6, 6.0]
qdd = [4.5, 45.0]
tau = [16.0, 3.0]
segments = 8
starts = 1
iterations = 12
"""
    )
    design = excite(open_session(str(tmp_path / "mine.toml")))
    assert not design.looped and design.used.max() <= 1.0
    motion = sample(design.waypoints, 100.0)
    D = regressor(motion.q, motion.qd, motion.qdd, SHARP).reshape(-1, 8) * np.where(TRUTH == 0.0, 0.05, TRUTH)
    assert design.log_det == pytest.approx(np.linalg.slogdet(D.T @ D)[1], rel=1e-8)


def test_an_output_that_cannot_be_written_is_refused_before_the_search(tmp_path):
    check_output(None)
    check_output(str(tmp_path / "new.csv"))
    check_output("/dev/null")
    for wrong in (tmp_path, tmp_path / "none" / "new.csv", "/proc/new.csv"):
        with pytest.raises(DataError, match=r"cannot be written there \(.+\); give --output"):
            check_output(str(wrong))
    with pytest.raises(DataError, match=r"not written as `.parquet`; name a .csv file"):
        check_output(str(tmp_path / "new.parquet"))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("segments=1", r"excitation.segments = 1 leaves nothing to search.* give 2 or more"),
        ("grid=0.01", r"excitation.grid = 0.01 Hz with segments of 1.25 s; give from 0.8 Hz .* to 1000 Hz"),
        ("grid=1e9", r"excitation.grid = 1e\+09 Hz"),
        ("tau=[0.3, 0.1]", r"excitation.tau does not overcome friction.*joint 1 needs 0.5\d* of 0.3.*; widen it"),
    ],
)
def test_settings_of_which_no_design_can_come_are_refused_before_the_search(fmus, override, message):
    def search(*_):
        raise AssertionError("the search began")

    with pytest.raises(ConfigError, match=message) as caught:
        excite(open_session("scara", [f"excitation.{override}"]), tell=search)
    assert "\n" not in str(caught.value)


def test_too_few_segments_for_the_validation_alone_are_named(fmus):
    session = open_session("scara", ["excitation.validation={segments=1, segment=1.5}"])
    with pytest.raises(ConfigError, match=r"excitation.validation.segments = 1"):
        excite(session, validation=True)


def test_limits_in_which_a_parameter_is_not_seen_name_it(fmus):
    with pytest.raises(IdentificationError, match=r"(\w+ is not excited|its cap).*widen"):
        excite(open_session("scara", [*SMALL, "excitation.tau=[0.8, 0.2]", "excitation.starts=1"]))


def test_a_stored_trajectory_beyond_the_limits_is_refused(fmus):
    with pytest.raises(DataError, match=r"scara_identification.csv: trajectory: joint 2 .* qd = .*its limit is 3; "):
        simulate(open_session("scara", ["excitation.qd=[2.8, 3.0]"]))


def test_what_is_built_is_found_again(small, tmp_path, fmus):
    """The design's file is one that an experiment can name."""
    shutil.copy(EXPERIMENTS / "scara.toml", tmp_path / "mine.toml")
    (tmp_path / "scara_validation.csv").write_text(waypoints_text(small.waypoints))
    (tmp_path / "scara_identification.csv").write_text(waypoints_text(small.waypoints))
    frame = simulate(open_session(str(tmp_path / "mine.toml")))
    assert len(frame) == 1001
