"""The model description: attributes, units, structure and its dependencies, names that XML has to escape."""

from xml.etree import ElementTree as ET

import pytest
from fmpy.validation import validate_fmu

from pipeline.export.model_description_fmi2 import describe
from pipeline.export.model_description_fmi3 import describe as describe_fmi3
from tests.export.language import archive_of, model_of

MODEL = """
model M "A \\"model\\" & <more> of µ-things"
  input Real u(unit="N.m") "Torque";
  output Real y(unit="rad");
  output Real direct;
  discrete output Real sampled(start=0, fixed=true);
  parameter Real J(quantity="MomentOfInertia", unit="kg.m2", min=0)=2 "Inertia <J>";
  parameter Real start(unit="deg")=0;
  parameter Real 'half & half'=J/2;
  Real q(unit="rad", displayUnit="deg", start=start, fixed=true, nominal=3);
  Real qd(unit="rad/s", start=0, fixed=true, min=-10, max=10);
equation
  der(q) = qd;
  J*der(qd) = u + sampled;
  y = q;
  direct = 2*u;
  when sample(0, 0.1) then
    sampled = -q + u;
  end when;
  when qd > 5 then
    reinit(qd, 0);
  end when;
  annotation (experiment(StopTime=3, Interval=0.01));
end M;
"""


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    text = describe(model_of(tmp_path_factory.mktemp("m"), MODEL), "m", "{guid}", ["a.c"])
    return ET.fromstring(text.encode())


def variables(root):
    return {v.get("name"): v for v in root.iter("ScalarVariable")}


def dependencies(root, group):
    names = list(variables(root))
    return {
        names[int(u.get("index")) - 1]: {names[int(i) - 1] for i in u.get("dependencies").split()}
        for u in root.find(f"ModelStructure/{group}")
    }


def test_names_and_descriptions_are_escaped(root):
    assert root.get("description") == 'A "model" & <more> of µ-things'
    assert variables(root)["'half & half'"].get("causality") == "calculatedParameter"


@pytest.mark.parametrize(
    "name, expected",
    {
        "u": ("input", "continuous", None),
        "y": ("output", "continuous", "calculated"),
        "sampled": ("output", "discrete", "exact"),
        "J": ("parameter", "tunable", "exact"),
        "start": ("parameter", "fixed", "exact"),
        "internalStep": ("parameter", "tunable", "exact"),
        "internalOrder": ("parameter", "tunable", "exact"),
        "q": ("local", "continuous", "calculated"),
        "qd": ("local", "continuous", "exact"),
        "der(qd)": ("local", "continuous", "calculated"),
    }.items(),
)
def test_causality_variability_and_initial(root, name, expected):
    variable = variables(root)[name]
    assert tuple(variable.get(key) for key in ("causality", "variability", "initial")) == expected


def test_attributes_of_the_declaration(root):
    inertia, q, qd = (variables(root)[name].find("Real").attrib for name in ("J", "q", "qd"))
    assert inertia == {"quantity": "MomentOfInertia", "unit": "kg.m2", "min": "0.0", "start": "2.0"}
    assert q == {"unit": "rad", "displayUnit": "deg", "nominal": "3.0"}
    assert qd == {"unit": "rad/s", "min": "-10.0", "max": "10.0", "start": "0.0", "reinit": "true"}
    assert variables(root)["J"].get("description") == "Inertia <J>"


def test_a_derivative_points_to_its_state(root):
    names = list(variables(root))
    derivative = variables(root)["der(q)"].find("Real")
    assert names[int(derivative.get("derivative")) - 1] == "q" and derivative.get("unit") == "rad/s"


def test_units_have_exponents(root):
    units = {unit.get("name"): unit for unit in root.iter("Unit")}
    assert units["kg.m2"].find("BaseUnit").attrib == {"kg": "1", "m": "2"}
    assert float(units["rad"].find("DisplayUnit").get("factor")) == pytest.approx(57.29577951308232)
    assert set(units) == {"N.m", "rad", "kg.m2", "deg", "rad/s", "rad/s2", "s"}


def test_the_structure_lists_true_dependencies(root):
    assert dependencies(root, "Outputs") == {"y": {"q"}, "direct": {"u"}, "sampled": {"q", "u"}}
    assert dependencies(root, "Derivatives") == {"der(q)": {"qd"}, "der(qd)": {"u", "q"}}
    initial = dependencies(root, "InitialUnknowns")
    assert initial["der(qd)"] == {"u", "J", "sampled"} and initial["q"] == {"start"} and initial["y"] == {"start"}
    assert initial["'half & half'"] == {"J"} and "qd" not in initial


def test_an_initial_equation_depends_on_the_start_values_it_names(tmp_path):
    text = """model M parameter Real a=3; Real y(start=1, fixed=true); Real x; initial equation x = 2*y + a;
      equation der(y) = 0; der(x) = -x; end M;"""
    root = ET.fromstring(describe(model_of(tmp_path, text), "m", "{guid}", ["a.c"]).encode())
    assert variables(root)["x"].get("initial") == "calculated" and variables(root)["y"].get("initial") == "exact"
    assert dependencies(root, "InitialUnknowns") == {"x": {"y", "a"}, "der(y)": set(), "der(x)": {"y", "a"}}


RELATIONS = """model M parameter Real T=0.5; parameter Real level=1; input Real u; output Real y; output Real z;
  output Real w; discrete output Real d(start=0, fixed=true); Real x(start=0, fixed=true); Real v(start=1, fixed=true);
  equation y = if u > level then 1 else -1; z = if time > T then 2 else 5; w = if x > 1 then v else 0; der(x) = y;
  der(v) = if y*x > 0 then 1 else 2; when x > 2 then d = if v > 3 then 1 else 2; end when; end M;"""


def test_what_a_relation_switches_depends_on_what_decides_it(tmp_path):
    root = ET.fromstring(describe(model_of(tmp_path, RELATIONS), "m", "{guid}", ["a.c"]).encode())
    assert dependencies(root, "Outputs") == {"y": {"u"}, "z": set(), "w": {"x", "v"}, "d": {"x", "v"}}
    assert dependencies(root, "Derivatives") == {"der(x)": {"u"}, "der(v)": {"u", "x"}}
    initial = dependencies(root, "InitialUnknowns")
    assert (initial["y"], initial["z"], initial["w"]) == ({"u", "level"}, {"T"}, {"x", "v"})
    assert initial["der(v)"] == {"u", "level", "x"}


def test_in_fmi_3_time_is_among_the_dependencies(tmp_path):
    root = ET.fromstring(describe_fmi3(model_of(tmp_path, RELATIONS), "m", "{token}").encode())
    names = {variable.get("valueReference"): variable.get("name") for variable in root.find("ModelVariables")}

    def used(group):
        entries = root.findall(f"ModelStructure/{group}")
        return {names[e.get("valueReference")]: {names[i] for i in e.get("dependencies").split()} for e in entries}

    assert used("Output") == {"y": {"u"}, "z": {"time"}, "w": {"x", "v"}, "d": {"x", "v"}}
    assert used("ContinuousStateDerivative") == {"der(x)": {"u"}, "der(v)": {"u", "x"}}
    assert used("InitialUnknown")["z"] == {"time", "T"}
    assert {"x", "u"} in used("EventIndicator").values()


def test_the_experiment_and_the_indicators(root):
    assert root.find("DefaultExperiment").attrib == {"stopTime": "3.0", "stepSize": "0.01"}
    assert root.get("numberOfEventIndicators") == "1"


def test_fmpy_finds_nothing_to_complain_about(tmp_path):
    assert validate_fmu(str(archive_of(tmp_path, MODEL).path)) == []
