"""A binding: the small TOML file that says which FMU variables are a plant's joints, inputs and parameters."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.config import convert, read_toml
from pipeline.errors import ConfigError
from pipeline.paths import BINDINGS
from pipeline.plant.fmu import Fmu
from pipeline.settings import Positive, Settings


class Joint(Settings):
    """One joint's variables in the FMU; `*_unit` is what the file's numbers mean, checked against the FMU.

    tau = gain·u: `gain` is a number, or comes with `gain_parameter`, the plant's own parameter that is set to it.
    position, velocity: what is read in Co-Simulation; position_state, velocity_state: the continuous states (where
    they bear other names); position_start, velocity_start: what sets the states in initialisation. u_range [the
    input's unit] is a command well inside every saturation: probing uses a tenth of it.
    """

    name: str
    input: str
    position: str
    velocity: str
    input_unit: str
    position_unit: str
    velocity_unit: str
    force_unit: str
    u_range: Positive
    position_state: str = ""
    velocity_state: str = ""
    position_start: str = ""
    velocity_start: str = ""
    gain: float = 1.0
    gain_parameter: str = ""
    gain_unit: str = ""


class Parameter(Settings):
    """A parameter to identify: its variable in the FMU (by default its name), unit, a-priori value and scale.

    scale: a typical size, in the parameter's unit: the step of a difference where the a-priori value is 0.
    """

    name: str
    unit: str
    a_priori: float
    scale: Positive
    variable: str = ""


class Binding(Settings):
    """A plant as the pipeline sees it: n joints, p parameters, and what else is set before it runs.

    set: always; probe: while the regressor is probed (for example friction so sharp that it is sign()); filter:
    while the filter runs; linearise: while the closed loop is linearised (for example Coulomb friction off). Paths in
    `fmu` are relative to the binding's folder.
    """

    fmu: str
    joint: tuple[Joint, ...]
    parameter: tuple[Parameter, ...]
    set: dict[str, float] = {}
    probe: dict[str, float] = {}
    filter: dict[str, float] = {}
    linearise: dict[str, float] = {}
    folder: str = ""

    @property
    def path(self) -> Path:
        """The FMU's file."""
        return Path(self.folder) / self.fmu

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joint)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters (p,)."""
        return tuple(p.name for p in self.parameter)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the parameters (p,)."""
        return tuple(p.unit for p in self.parameter)

    @property
    def a_priori(self) -> np.ndarray:
        """A-priori values of the parameters (p,)."""
        return np.array([p.a_priori for p in self.parameter])

    @property
    def scale(self) -> np.ndarray:
        """Typical sizes of the parameters (p,)."""
        return np.array([p.scale for p in self.parameter])

    @property
    def gain(self) -> np.ndarray:
        """Drive gains (n,): tau = gain·u."""
        return np.array([j.gain for j in self.joint])

    @property
    def u_range(self) -> np.ndarray:
        """Commands (n,) well inside every saturation."""
        return np.array([j.u_range for j in self.joint])

    def select(self, values: np.ndarray, names: tuple[str, ...]) -> np.ndarray:
        """The entries of values (p,) that belong to the parameters called `names`, in their order."""
        return np.array([values[self.names.index(name)] for name in names])

    def gains_to_set(self) -> dict[str, float]:
        """The drive gains that are the plant's own parameters: {variable: value}."""
        return {j.gain_parameter: j.gain for j in self.joint if j.gain_parameter}

    def start_values(self, chi: np.ndarray | None = None) -> dict[str, float]:
        """Everything set in initialisation: `set`, the drive gains, the parameters at chi (p,) (default: a priori)."""
        chi = self.a_priori if chi is None else chi
        values = {p.variable or p.name: float(v) for p, v in zip(self.parameter, chi, strict=True)}
        return {**self.set, **self.gains_to_set(), **values}


def load_binding(name_or_path: str, base: Path | None = None) -> Binding:
    """The binding `fmus/<name>.toml`, or the one in a TOML file (relative to `base`, the experiment's folder)."""
    path = Path(name_or_path)
    if path.suffix != ".toml":
        path = BINDINGS / f"{name_or_path}.toml"
    elif base is not None and not path.is_absolute() and not path.is_file():
        path = base / path
    if not path.is_file():
        known = sorted(p.stem for p in BINDINGS.glob("*.toml"))
        raise ConfigError(f"{path}: no such binding; known ones are {', '.join(known)}, or give a path to a .toml file")
    binding = convert({"folder": str(path.parent), **read_binding(path)}, Binding, path.name)
    _check_roles(binding, path.name)
    return binding


def _check_roles(binding: Binding, where: str) -> None:
    """Each variable serves once: among those that are set, and among those that are read; a gain moves its joint."""
    joints = binding.joint
    to_set = [j.input for j in joints] + [p.variable or p.name for p in binding.parameter]
    to_set += [name for j in joints for name in (j.position_start, j.velocity_start, j.gain_parameter) if name]
    to_read = [name for j in joints for name in (j.position, j.velocity)]
    for name in (*to_set, *to_read):
        if to_set.count(name) > 1 or to_read.count(name) > 1:
            raise ConfigError(f"{where}: `{name}` is bound twice; each variable can serve once")
    for joint in joints:
        if joint.gain == 0.0:
            raise ConfigError(f"{where}: joint {joint.name}: gain is 0, so no input moves it; give force per input")


def read_binding(path: Path) -> dict:
    """The table of a binding; its `extends` names another one, in its folder, whose keys it takes over or replaces."""
    table = read_toml(path)
    base = table.pop("extends", None)
    if base is None:
        return table
    if not isinstance(base, str) or not (path.parent / base).is_file():
        raise ConfigError(f"{path.name}: extends `{base}`, which is no file beside it; name a binding there")
    extended = read_toml(path.parent / base)
    if "extends" in extended:
        raise ConfigError(f"{path.name}: extends `{base}`, which extends another one; name that one")
    return {**extended, **table}


def check_binding(binding: Binding, file: Fmu) -> None:
    """Hold the binding against the model description: names, causality, units. Raises ConfigError."""
    for joint in binding.joint:
        _expect(file, joint.input, ("input",), joint.input_unit)
        _expect(file, joint.position, (), joint.position_unit)
        _expect(file, joint.velocity, (), joint.velocity_unit)
        _expect(file, joint.position_state or joint.position, (), joint.position_unit)
        _expect(file, joint.velocity_state or joint.velocity, (), joint.velocity_unit)
        if joint.gain_parameter:
            _expect(file, joint.gain_parameter, ("parameter",), joint.gain_unit)
    for parameter in binding.parameter:
        _expect(file, parameter.variable or parameter.name, ("parameter", "input"), parameter.unit)
    for name in (*binding.set, *binding.probe, *binding.filter, *binding.linearise):
        file.variable(name)


def _expect(file: Fmu, name: str, causalities: tuple[str, ...], unit: str) -> None:
    variable = file.variable(name)
    if causalities and variable.causality not in causalities:
        wanted = " or ".join(causalities)
        raise ConfigError(
            f"{file.path.name}: `{name}` is of causality {variable.causality} there, the binding wants {wanted}"
        )
    declared = variable.unit or (variable.declaredType.unit if variable.declaredType is not None else None)
    if declared is not None and declared != unit:
        raise ConfigError(
            f"{file.path.name}: `{name}`: the FMU says `{declared}`, the binding says `{unit}`; make them one"
        )


def gains_of_bindings() -> dict[str, dict[str, float]]:
    """{FMU: {gain parameter: value}} for each plant of ours and its closed loop: a binding is the gain's one place."""
    gains = {path.stem: load_binding(str(path)).gains_to_set() for path in sorted(BINDINGS.glob("*.toml"))}
    loops = {f"{name}_closed_loop": gain for name, gain in gains.items() if not name.endswith("_inputs")}
    return {name: gain for name, gain in (gains | loops).items() if gain}


def variants_of_bindings() -> dict[str, tuple[str, tuple[str, ...]]]:
    """{"scara_inputs": ("scara", parameters)}: plants of ours whose parameters are continuous inputs of the FMU."""
    variants = {}
    for path in sorted(BINDINGS.glob("*_inputs.toml")):
        parameters = tuple(p.variable or p.name for p in load_binding(str(path)).parameter)
        variants[path.stem] = (path.stem.removesuffix("_inputs"), parameters)
    return variants
