"""The layer of FMI 3.0: every function, wrong calls included, and what its model description says."""

import re
from ctypes import CDLL, POINTER, byref, c_bool, c_double, c_int, c_void_p
from pathlib import Path
from xml.etree import ElementTree as ET
from zipfile import ZipFile

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Model, FMU3ScheduledExecution, FMU3Slave
from fmpy.validation import validate_fmu

from pipeline.export.compiler import headers
from tests.export.language import archive_of

MODEL = """
model M
  input Real u(start=0.5);
  input Integer n(start=3);
  input Boolean on(start=true);
  parameter Real k=2;
  output Real y=k*x;
  output Integer twice=2*n;
  output Boolean off=not on;
  discrete Real seen(start=0, fixed=true);
  Real x(start=1, fixed=true, unit="m", displayUnit="mm");
equation
  der(x) = if x > 0.5 then -x + sin(time) else u;
  when {x < 0.25, sample(0, 0.5)} then
    seen = x;
  end when;
end M;
"""
ERROR = 3
TYPES = (headers() / "fmi3FunctionTypes.h").read_text()
FUNCTIONS = re.findall(r"typedef fmi3Status (fmi3\w+?)TYPE *\(", TYPES)
ABSENT = ("Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "Int64", "UInt64")


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    archive = archive_of(tmp_path_factory.mktemp("fmi3"), MODEL, fmi="3")
    yield archive
    archive.close()


@pytest.fixture(scope="module")
def library(archive):
    (path,) = Path(archive.folder).rglob("M.so")
    return CDLL(str(path))


@pytest.fixture(scope="module")
def root(archive):
    return ET.fromstring(ZipFile(archive.path).read("modelDescription.xml"))


def variables(root):
    return {v.get("name"): v for v in root.find("ModelVariables")}


# --- functions -------------------------------------------------------------------------------------------------------


def test_the_header_lists_the_functions_that_give_a_status():
    assert len(FUNCTIONS) == 75 - 5  # all but GetVersion, three Instantiate… and FreeInstance


@pytest.mark.parametrize("function", FUNCTIONS)
def test_no_function_works_without_an_instance(library, function):
    assert library[function](None) == ERROR


@pytest.mark.parametrize("function", FUNCTIONS)
def test_a_call_in_a_wrong_mode_is_logged_under_its_own_name(archive, library, capfd, function):
    """No mode is wrong for every function: here the first number of the instance, which is its mode, becomes 0."""
    with archive.co_simulation() as instance:
        mode = c_int.from_address(instance.fmu.component)
        right, mode.value = mode.value, 0
        status = library[function](c_void_p(instance.fmu.component))
        mode.value = right
    assert status == ERROR
    assert f"{function}: not allowed in the state" in capfd.readouterr().out


def test_the_version_is_3_0_and_freeing_nothing_does_nothing(archive, library):
    with archive.co_simulation() as instance:
        assert instance.fmu.getVersion() in ("3.0", b"3.0")
    library.fmi3FreeInstance(None)


# --- instances -------------------------------------------------------------------------------------------------------


def instance_of(kind, archive, guid=None):
    return kind(
        guid=guid or archive.description.guid,
        unzipDirectory=archive.folder,
        modelIdentifier="M",
        instanceName="test",
    )


@pytest.mark.parametrize(
    ("kind", "guid", "options", "message"),
    [
        (FMU3Model, "{0}", {}, "the instantiation token is {0}, but the model description of M must have"),
        (FMU3Slave, "{0}", {}, "the instantiation token is {0}"),
        (
            FMU3Slave,
            None,
            {"eventModeUsed": True},
            "M has no Event Mode in Co-Simulation (hasEventMode): eventModeUsed",
        ),
        (FMU3ScheduledExecution, None, {}, "M offers Model Exchange and Co-Simulation, no Scheduled Execution"),
    ],
)
def test_what_cannot_be_instantiated_is_refused_with_a_reason(archive, capfd, kind, guid, options, message):
    with pytest.raises(Exception, match="instantiate"):
        instance_of(kind, archive, guid).instantiate(**options)
    assert message in capfd.readouterr().out


# --- values ----------------------------------------------------------------------------------------------------------


def test_integers_and_booleans_are_read_and_set(archive):
    refs = archive.references
    with archive.co_simulation() as instance:
        fmu = instance.fmu
        assert fmu.getInt32([refs["n"], refs["twice"]]) == [3, 6]
        assert fmu.getBoolean([refs["on"], refs["off"]]) == [True, False]
        fmu.setInt32([refs["n"]], [-5])
        fmu.setBoolean([refs["on"]], [False])
        instance.step(0.0, 0.1)  # what is discrete follows at the next event
        assert fmu.getInt32([refs["twice"]]) == [-10] and fmu.getBoolean([refs["off"]]) == [True]


def test_time_and_event_indicators_can_be_read(archive):
    with archive.model_exchange() as instance:
        instance.rhs(0.125, [0.75])
        assert instance.get("time", "'event indicator 1'") == pytest.approx([0.125, 0.25 + 1e-12], abs=1e-15)
        assert instance.fmu.getNumberOfEventIndicators() == 2 and instance.fmu.getNumberOfContinuousStates() == 1
        indicators = np.zeros(2)
        instance.fmu.getEventIndicators(indicators.ctypes.data_as(POINTER(c_double)), 2)
        assert indicators == pytest.approx(instance.get("'event indicator 1'", "'event indicator 2'"), abs=0)


@pytest.mark.parametrize("kind", ABSENT)
def test_types_that_no_variable_has_are_refused_unless_nothing_is_asked(archive, capfd, kind):
    with archive.co_simulation() as instance:
        assert getattr(instance.fmu, f"get{kind}")([]) == []
        for call in (
            lambda: getattr(instance.fmu, f"get{kind}")([0]),
            lambda: getattr(instance.fmu, f"set{kind}")([0], [1]),
        ):
            with pytest.raises(FMICallException):
                call()
    assert capfd.readouterr().out.count(f"M has no {kind} variables") == 2


WRONG = {
    "unknown reference": (lambda i: i.fmu.getFloat64([9999]), "value reference 9999 is no Real variable of M"),
    "wrong type": (lambda i: i.fmu.getInt32([0]), "value reference 0 is no Integer variable of M"),
    "too many values": (
        lambda i: i.fmu.getFloat64([0], nValues=2),
        "2 values for 1 variables: every variable is a scal",
    ),
    "string": (lambda i: i.fmu.getString([0]), "M has no String variables"),
    "binary": (lambda i: i.fmu.setBinary([0], [b"1"]), "M has no Binary variables"),
    "clock": (lambda i: i.fmu.getClock([0]), "M has no clocks"),
    "time": (lambda i: i.set(time=1.0), "time cannot be set now: it is the independent variable"),
    "nan": (lambda i: i.set(u=np.nan), "u cannot be set to what is not a number"),
    "another time": (lambda i: i.step(0.5, 0.1), "the step starts at 0.5 s, but the instance stands at 0 s"),
    "event mode": (lambda i: i.fmu.enterEventMode(), "not allowed in the state Step Mode"),
    "step mode": (lambda i: i.fmu.enterStepMode(), "M has no Event Mode in Co-Simulation"),
    "configuration": (lambda i: i.fmu.enterConfigurationMode(), "not allowed|M has no structural parameters"),
    "output derivatives": (lambda i: i.fmu.getOutputDerivatives([0], [1]), "M provides no derivatives of outputs"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_call_fails_with_one_message(archive, capfd, case):
    call, message = WRONG[case]
    with archive.co_simulation() as instance:
        capfd.readouterr()
        with pytest.raises(FMICallException):
            call(instance)
        lines = [line for line in capfd.readouterr().out.splitlines() if "fmi3" in line and ": " in line]
        assert any(re.search(message, line) for line in lines), lines


def test_a_step_tells_how_far_it_came(archive, library):
    with archive.co_simulation() as instance:
        assert instance.fmu.doStep(0.0, 0.3) == (False, False, False, 0.3)
        assert instance.fmu.doStep(0.3, 0.4)[-1] == 0.7
    with archive.co_simulation(internalStep=1e-3) as instance:
        instance.set(k=1.0)
        flags, last = [c_bool() for _ in range(3)], c_double(-1.0)
        instance.set(internalStep=0.0)
        arguments = [c_void_p(instance.fmu.component), c_double(0.0), c_double(0.1), c_bool(True)]
        status = library.fmi3DoStep(*arguments, *map(byref, flags), byref(last))
        assert status == 2 and last.value == 0.0 and not any(flag.value for flag in flags)


def test_events_are_handled_in_model_exchange(archive):
    with archive.model_exchange() as instance:
        assert instance.next_event == 0.5
        instance.rhs(0.1, [0.2])
        assert instance.get("der(x)") == pytest.approx([np.sin(0.1) - 0.2])  # the relation is still held
        instance.event()
        assert instance.get("der(x)", "seen") == pytest.approx([0.5, 0.2])


# --- description -----------------------------------------------------------------------------------------------------


def test_fmpy_finds_nothing_to_complain_about(archive):
    assert validate_fmu(str(archive.path)) == []


def test_the_attributes_stand_on_elements_named_by_type(root):
    found = variables(root)
    assert {name: found[name].tag for name in ("u", "n", "on", "twice", "seen")} == {
        "u": "Float64", "n": "Int32", "on": "Boolean", "twice": "Int32", "seen": "Float64",
    }  # fmt: skip
    assert (found["n"].get("start"), found["on"].get("start"), found["u"].get("start")) == ("3", "true", "0.5")
    assert found["x"].get("unit") == "m" and found["x"].get("displayUnit") == "mm"
    assert found["der(x)"].get("derivative") == found["x"].get("valueReference")


def test_value_references_are_unique_and_time_is_the_one_independent_variable(root):
    found = variables(root)
    references = [v.get("valueReference") for v in found.values()]
    assert len(set(references)) == len(references)
    assert [name for name, v in found.items() if v.get("causality") == "independent"] == ["time"]
    assert found["time"].get("start") is None


def test_the_structure_names_value_references(root):
    names = {v.get("valueReference"): name for name, v in variables(root).items()}
    structure = {
        (item.tag, names[item.get("valueReference")]): {names[r] for r in item.get("dependencies").split()}
        for item in root.find("ModelStructure")
    }
    assert structure["ContinuousStateDerivative", "der(x)"] == {"x", "u", "time"}
    assert structure["Output", "y"] == {"x"} and structure["Output", "twice"] == {"n"}
    assert structure["EventIndicator", "'event indicator 1'"] == {"x"}
    assert structure["InitialUnknown", "y"] == {"k", "x"}
    assert sum(tag == "EventIndicator" for tag, _ in structure) == 2


def test_capabilities_are_declared_and_event_mode_is_not(root):
    for interface in ("ModelExchange", "CoSimulation"):
        element = root.find(interface)
        for flag in ("canGetAndSetFMUState", "canSerializeFMUState", "providesDirectionalDerivatives",
                     "providesAdjointDerivatives"):  # fmt: skip
            assert element.get(flag) == "true"
        assert element.get("hasEventMode") is None and element.get("modelIdentifier") == "M"
    assert root.find("ScheduledExecution") is None
