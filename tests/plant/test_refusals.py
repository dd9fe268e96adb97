"""Plants that a filter or a probe could only get wrong, in silence, are refused when they are opened."""

import pytest

from pipeline.errors import FmuError
from pipeline.export.build import export
from pipeline.export.catalogue import Recipe
from pipeline.plant.binding import load_binding
from pipeline.plant.plant import open_plant

BINDING = """
fmu = "{name}.fmu"
[[joint]]
name = "axis"
input = "u"
input_unit = "N"
force_unit = "N"
u_range = 10.0
position = "q"
position_unit = "m"
velocity = "qd"
velocity_unit = "m/s"
position_state = "x"
velocity_state = "v"
position_start = "q0"
velocity_start = "v0"
[[parameter]]
name = "Fc"
unit = "N"
a_priori = 0.5
scale = 0.1
"""
MODEL = """
model {name} "One axis"
  input Real u(unit="N") "Force";
  output Real q(unit="m") "Position";
  output Real qd(unit="m/s") "Velocity";
  parameter Real Fc(unit="N") = 0.5 "Friction";
  parameter Real q0(unit="m") = 0 "Start";
  parameter Real v0(unit="m/s") = 0 "Start";
  Real x(start=q0, fixed=true) "Position";
  Real v(start=v0, fixed=true) "Velocity";
  {extra}
equation
  q = x;
  qd = v;
  der(x) = v;
  {equations}
end {name};
"""
MODELS = {
    "Branches": ("", "der(v) = u - (if v > 0 then Fc else -Fc);"),
    "Lag": ('Real f(start=0, fixed=true) "Actuator";', "der(f) = (u - f)/0.05;\n  der(v) = f - Fc*v;"),
}


@pytest.fixture(scope="module")
def plants(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plants")
    for name, (extra, equations) in MODELS.items():
        source = folder / f"{name}.mo"
        source.write_text(MODEL.format(name=name, extra=extra, equations=equations))
        export(source, Recipe(name, {}), {"2": folder / f"{name}.fmu"})
        (folder / f"{name}.toml").write_text(BINDING.format(name=name))
    return folder


@pytest.mark.parametrize("interface", ["ME", "CS"])
@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Branches", r"Branches\.fmu: 1 event indicators: its equations have branches"),
        ("Lag", r"Lag\.fmu: besides positions and velocities it has the states f"),
    ],
)
def test_branches_and_hidden_states_are_refused(plants, name, message, interface):
    with (
        pytest.raises(FmuError, match=message),
        open_plant(load_binding(str(plants / f"{name}.toml")), interface=interface),
    ):
        pass
