"""The front end's view of every model that can run: it loads, it is square, its metadata is complete."""

import pytest

from tests.modelica.sources import PACKAGE

rumoca = pytest.importorskip("rumoca", reason="the Modelica front end is not installed")

ROOMS = {room: (PACKAGE / room / "package.order").read_text().split() for room in ("FMUs", "Examples")}
RUNNABLE = [f"{room}.{name}" for room, names in ROOMS.items() for name in names]
PORTS = {
    "Scara": ("tau_1 tau_2", "q_1 q_2 qd_1 qd_2"),
    "ScaraController": ("qr_1 qr_2 qdr_1 qdr_2 q_1 q_2", "tau_1 tau_2"),
    "ScaraControllerContinuous": ("qr_1 qr_2 qdr_1 qdr_2 q_1 q_2", "tau_1 tau_2"),
    "ScaraClosedLoop": ("qr_1 qr_2 qdr_1 qdr_2", "q_1 q_2 qd_1 qd_2 tau_1 tau_2"),
    "Emps": ("u", "q qd"),
    "EmpsController": ("qr pulse q", "u"),
    "EmpsClosedLoop": ("qr pulse", "q qd u"),
}


@pytest.fixture(scope="module")
def load():
    session = rumoca.Session()
    return lambda name: session.load(str(PACKAGE / "package.mo"), model=f"RobotIdentification.{name}")


def variables(model):
    return model.to_dict("dae")["storage"]["variables"]


@pytest.mark.parametrize("name", RUNNABLE)
def test_every_variable_of_a_model_has_unit_and_description(load, name):
    found = variables(load(name))
    assert len(found) > 4
    lacking = [v["name"] for v in found if not v["attributes"]["unit"] or not v["attributes"]["description"]]
    assert lacking == []


@pytest.mark.parametrize("name", PORTS)
def test_the_ports_of_an_export_are_its_contract(load, name):
    found = [(v["attributes"]["causality"], v["name"]) for v in variables(load(f"FMUs.{name}"))]
    for causality, names in zip(("input", "output"), PORTS[name], strict=True):
        assert [n for c, n in sorted(found) if c == causality] == sorted(names.split())


def test_the_contract_lists_every_export():
    assert sorted(PORTS) == sorted((PACKAGE / "FMUs/package.order").read_text().split())


@pytest.mark.parametrize(
    ("name", "output", "reference", "error"),
    [
        ("ScaraSampledLoop", "closedLoop.q_1", "reference_1.qr", 0.05),
        ("ScaraContinuousLoop", "plant.q_2", "reference_2.qr", 0.25),
        ("EmpsLoop", "closedLoop.q", "reference.qr", 2e-3),
    ],
)
def test_an_example_follows_its_reference_in_an_independent_simulator(load, name, output, reference, error):
    result = load(f"Examples.{name}").simulate(t=1.0)
    follow = max(abs(a - b) for a, b in zip(result[output], result[reference], strict=True))
    assert 0 < follow < error
    assert max(map(abs, result[reference])) > 2 * error
