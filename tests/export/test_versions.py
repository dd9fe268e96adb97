"""FMI 2.0 and 3.0 of one FMU: the same trajectories to the last bit; the FMU state replays in a process of its own."""

import sys
from subprocess import run

import numpy as np
import pytest
from fmpy import simulate_fmu

from pipeline.paths import ROOT
from tests.export.language import archive_of
from tests.export.test_events import BALL, SWITCH
from tests.export.test_fmus_states import DRIVEN, march, march_exchange

INTERFACES = {"co_simulation": march, "model_exchange": march_exchange}
VERSIONS = ("", "_fmi3")

REPLAY = """
import sys
from tests.export.driver import Archive
from tests.export.test_versions import INTERFACES
path, name, interface, due = sys.argv[1:]
archive = Archive(path)
try:
    with getattr(archive, interface)() as instance:
        instance.load(sys.stdin.buffer.read())
        instance.next_event = float(due) if due != "None" else None
        sys.stdout.write(INTERFACES[interface](instance, name, 23, 60).tobytes().hex())
finally:
    archive.close()
"""


def trajectory(archive, name, interface):
    """The outputs of 60 steps as bytes; they do move."""
    with getattr(archive, interface)() as instance:
        rows = INTERFACES[interface](instance, name, 0, 60)
    assert np.ptp(rows, axis=0).min() > 0
    return rows.tobytes()


def replays_in_a_new_process(archive, name, interface):
    """Whether a serialised FMU state goes on there as it does here, to the last bit."""
    with getattr(archive, interface)() as instance:
        INTERFACES[interface](instance, name, 0, 23)
        frozen, due = instance.save(), getattr(instance, "next_event", None)
        expected = INTERFACES[interface](instance, name, 23, 60)
    arguments = [sys.executable, "-c", REPLAY, str(archive.path), name, interface, repr(due)]
    found = run(arguments, input=frozen, capture_output=True, check=True, cwd=ROOT).stdout.decode()
    return found == expected.tobytes().hex()


@pytest.mark.parametrize("name", DRIVEN)
@pytest.mark.parametrize("interface", INTERFACES)
def test_both_versions_give_the_same_trajectories_to_the_last_bit(archives, name, interface):
    two, three = (trajectory(archives(name + version), name, interface) for version in VERSIONS)
    assert two == three


@pytest.mark.parametrize("version", VERSIONS, ids=["FMI 2", "FMI 3"])
@pytest.mark.parametrize("name", DRIVEN)
@pytest.mark.parametrize("interface", INTERFACES)
def test_a_serialised_state_replays_bit_for_bit_in_a_new_process(archives, name, interface, version):
    assert replays_in_a_new_process(archives(name + version), name, interface)


@pytest.mark.parametrize("name", ["scara", "emps_closed_loop"])
def test_a_state_of_one_version_continues_in_the_other(archives, name):
    with archives(name).co_simulation() as one, archives(f"{name}_fmi3").co_simulation() as other:
        march(one, name, 0, 23)
        other.load(one.save())
        assert march(other, name, 23, 60).tobytes() == march(one, name, 23, 60).tobytes()


@pytest.mark.parametrize("interface", ["ModelExchange", "CoSimulation"])
@pytest.mark.parametrize("text", [BALL, SWITCH], ids=["ball", "switch"])
def test_fmpys_own_simulation_finds_the_same_events_in_both_versions(tmp_path, text, interface):
    results = []
    for version in ("2", "3"):
        archive = archive_of(tmp_path, text, fmi=version)
        results.append(simulate_fmu(str(archive.path), stop_time=1.2, output_interval=0.01, fmi_type=interface))
        archive.close()
    assert results[0].dtype == results[1].dtype and results[0].tobytes() == results[1].tobytes()


@pytest.mark.parametrize("version", ["2", "3"])
def test_in_the_initialisation_a_relation_is_what_the_start_values_make_it(tmp_path, version):
    archive = archive_of(tmp_path, SWITCH, fmi=version)
    with archive.initialization_mode() as instance:
        assert instance.get("der(x)") == -1.0
        instance.set(level=2.0)
        assert instance.get("der(x)") == -0.5
    archive.close()
