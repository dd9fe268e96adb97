"""The Co-Simulation slave: values go in and out, every failure is one line, nothing is left behind."""

from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import FmuError, FmuidError
from pipeline.plant.cosimulation import Slave
from pipeline.plant.fmu import open_fmu
from tests.plant.misbehaving import build_misbehaving

pytestmark = pytest.mark.usefixtures("temporary_folders")


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    path = build_misbehaving(tmp_path_factory.mktemp("fmu"))
    if path is None:
        pytest.skip("no C compiler")
    return path


def run(fmu, start, steps=5):
    with Slave(fmu, start) as slave:
        u, y = slave.port(["u"]), slave.port(["y"])
        for k in range(steps):
            u.write([k])
            slave.step(0.1 * k, 0.1)
            yield y.read().item()


def test_inputs_go_in_and_outputs_come_out(fmu):
    assert list(run(fmu, {})) == [0.0, 2.0, 4.0, 6.0, 8.0]


def test_ports_keep_their_order_and_copy_what_they_read(fmu):
    with Slave(fmu, {"status": 3.0}) as slave:
        slave.port(["y", "u"]).write([1.0, 2.0])
        port = slave.port(["u", "status", "y"])
        first = port.read()
        slave.port(["u"]).write([5.0])
        np.testing.assert_array_equal(first, [2.0, 3.0, 1.0])
        np.testing.assert_array_equal(port.read(), [5.0, 3.0, 1.0])


@pytest.mark.parametrize(("status", "word"), [(1, "Warning"), (2, "Discard"), (3, "Error"), (5, "Pending"), (9, "9")])
def test_every_status_but_ok_stops_the_run_with_fmu_call_and_time(fmu, status, word):
    with pytest.raises(FmuError, match=rf"misbehaving.fmu: fmi2DoStep at t = 0.3 s returned .*{word}") as caught:
        list(run(fmu, {"fail_at": 0.25, "status": status}))
    assert "\n" not in str(caught.value)


def test_an_output_that_becomes_nan_is_named_with_its_time(fmu):
    with pytest.raises(FmuError, match=r"misbehaving.fmu: `y` became nan at t = 0.3 s"):
        list(run(fmu, {"nan_at": 0.15}))


def test_nan_is_never_given_to_the_fmu(fmu):
    with Slave(fmu) as slave, pytest.raises(FmuError, match="`u` is given nan at t = 0 s"):
        slave.port(["u"]).write([np.nan])


def test_a_failed_initialisation_and_a_refused_value_are_errors(fmu):
    with pytest.raises(FmuError, match="misbehaving.fmu: fmi2ExitInitializationMode"):
        Slave(fmu, {"refuse": 1.0})
    with pytest.raises(FmuError, match=r"misbehaving.fmu: fmi2SetReal at t = 0 s returned Error"):
        list(run(fmu, {"refuse": 2.0}))


@pytest.mark.parametrize(
    ("start", "words"),
    [({"stat": 1.0}, "no variable `stat`; nearest: status"), ({"count": 1.0}, "`count` is of type Integer")],
)
def test_wrong_names_and_types_are_refused(fmu, start, words):
    with pytest.raises(FmuidError, match=words):
        Slave(fmu, start)


def test_a_missing_file_is_an_error(tmp_path):
    with pytest.raises(FmuError, match="no such FMU"):
        Slave(tmp_path / "none.fmu")


def test_an_opened_fmu_is_left_to_its_owner(fmu):
    with open_fmu(fmu) as file:
        with Slave(file) as first, Slave(file, {"status": 2.0}) as second:
            assert first.file is second.file is file
        assert Path(file.folder).is_dir()
        first.close()


def test_each_instance_gets_its_own_messages(fmus):
    """The plant fails while the controller's instance is the newer one: the reason must still be the plant's."""
    with Slave(fmus / "scara.fmu", {"ZZR1": 0.0, "ZZ2": 0.0}) as plant, Slave(fmus / "scara_controller.fmu"):
        plant.port(["tau_1", "tau_2"]).write(np.array([5.0, 1.0]))
        with pytest.raises(FmuError, match=r"scara\.fmu: fmi2DoStep .* is not a number"):
            for k in range(50):
                plant.step(0.01 * k, 0.01)
