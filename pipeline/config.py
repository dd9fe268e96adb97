"""An experiment's TOML file as typed settings. An unknown key is refused, with the nearest known one."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec

from pipeline.errors import ConfigError
from pipeline.paths import EXPERIMENTS

Positive = Annotated[float, msgspec.Meta(gt=0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
Count = Annotated[int, msgspec.Meta(ge=1)]


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of every group of settings: frozen, and strict about its keys."""


class Filter(Settings):
    """A low-pass filter: Butterworth with `cutoff` [Hz] and `order`, or the usual decimation filter.

    "zero-phase" runs forward and backward, "forward" only forward (it lags), "none" passes the signal through;
    "decimate" is the 8th-order Chebyshev type I filter (0.05 dB, 0.8·Nyquist/decimation), forward and backward.
    """

    kind: Literal["zero-phase", "forward", "none", "decimate"]
    cutoff: NotNegative = 0.0
    order: Count = 4


class WlsSettings(Settings):
    """How one WLS variant filters: the position, then y and every column of W in parallel, then 1 of `decimation`.

    border: samples cut at the (beginning, end), counted at the original rate; half_sample: align the torque held
    over a sample with the position measured at its end.
    """

    name: str
    position: Filter
    parallel: Filter
    decimation: Count = 1
    border: tuple[int, int] = (0, 0)
    half_sample: bool = True


class ControllerSettings(Settings):
    """The controller FMU and its ports, one per joint: references, measured positions, commands, extra inputs."""

    fmu: str
    period: Positive
    reference: tuple[str, ...]
    position: tuple[str, ...]
    output: tuple[str, ...]
    reference_velocity: tuple[str, ...] = ()
    extra: tuple[str, ...] = ()
    start: dict[str, float] = {}
    position_start: tuple[str, ...] = ()
    velocity_start: tuple[str, ...] = ()


class SimulationSettings(Settings):
    """Where simulated data come from: the stored trajectories, the true parameters, the noise and the sampling.

    sigma_q [rad or m], sigma_u [the plant input's unit]: one per joint; rate [Hz]; loop: "disturbed" (the noise acts
    in the loop) or "clean" (it stands in the record only).
    """

    identification: str
    validation: str
    rate: Positive
    truth: dict[str, float]
    sigma_q: tuple[NotNegative, ...]
    sigma_u: tuple[NotNegative, ...]
    loop: Literal["disturbed", "clean"] = "disturbed"


class Column(Settings):
    """One column of a measured file: its name and unit there; value = scale · (converted) + offset [our unit]."""

    source: str
    unit: str
    scale: float = 1.0
    offset: float = 0.0


class DataSettings(Settings):
    """Measured data: the files, the frame's columns (`time`, `q_1`, `u_1`, `qr_1`, `pulse_1` …) and the rate [Hz].

    validation_columns come on top of `columns` in the validation file; `pulse_i` feeds the controller's extra inputs in
    a re-simulation; `source` says where to get the files; `folder` is where they are, unless `--data` says otherwise.
    """

    identification: str
    validation: str
    rate: Positive
    columns: dict[str, Column]
    validation_columns: dict[str, Column] = {}
    source: str = ""
    folder: str = ""


class EkfCase(Settings):
    """One start of the filter and its tunings; a run is called `name`, or `name tuning` where there is a choice.

    chi0 (p,) or wls_factor: the start, as numbers or as a multiple of the recommended WLS estimate. Its spread:
    P0_parameters (p,), variances; or P0_relative, the standard deviation as a fraction of |chi0|; or P0_sigmas, the
    same as a multiple of WLS's sigma. R (n,) and Q (2n,): the paper's
    covariances, needed by the tuning "paper". P0_state, method and substeps override those of `[ekf]`.
    """

    name: str
    tunings: tuple[Literal["paper", "known", "derived"], ...]
    chi0: tuple[float, ...] = ()
    wls_factor: float | None = None
    P0_state: tuple[Positive, ...] = ()
    P0_parameters: tuple[NotNegative, ...] = ()
    P0_relative: Positive | None = None
    P0_sigmas: Positive | None = None
    R: tuple[Positive, ...] = ()
    Q: tuple[NotNegative, ...] = ()
    method: Literal["euler", "rk4"] | None = None
    substeps: Count | None = None


class EkfSettings(Settings):
    """The extended Kalman filter: transition, Jacobian, covariance form and the cases to run.

    P0_state (2n,): variances of [qd, q] at the start; start_at_rest: begin with qd = 0, else with the filtered
    velocity of the first sample; recommended: the estimate that the verdict judges.
    """

    P0_state: tuple[Positive, ...]
    case: tuple[EkfCase, ...]
    recommended: str = ""
    start_at_rest: bool = True
    method: Literal["euler", "rk4"] = "rk4"
    substeps: Count = 4
    interface: Literal["ME", "CS"] = "ME"
    jacobian: Literal["forward", "central"] = "forward"
    covariance: Literal["udu", "joseph"] = "udu"


class ClosedLoopSettings(Settings):
    """The re-simulation of the identified model in closed loop: which estimate, and the rows cut at both ends."""

    estimate: str
    border: tuple[int, int] = (0, 0)


class LimitSettings(Settings):
    """Limits of the verdict; one that is absent is not judged."""

    condition_number_W: float | None = None
    condition_number_Phi: float | None = None
    relative_sigma_percent: float | None = None
    truth_sigmas: float | None = None
    force_error_percent: float | None = None
    above_noise_floor_percent: float | None = None
    closed_loop_position_percent: float | None = None
    closed_loop_force_percent: float | None = None


class Experiment(Settings):
    """A whole experiment: a plant (its binding), where the data come from, the estimators, the limits.

    Measured `data` come before `simulation` where an experiment has both; `recommended` names the WLS variant that
    everything else builds on; `reference` holds published results and goes into the record as it is.
    """

    name: str
    title: str
    plant: str
    controller: ControllerSettings
    wls: tuple[WlsSettings, ...]
    recommended: str
    seed: int = 0
    simulation: SimulationSettings | None = None
    data: DataSettings | None = None
    ekf: EkfSettings | None = None
    closed_loop: ClosedLoopSettings | None = None
    limits: LimitSettings = LimitSettings()
    reference: dict[str, Any] = {}


def load_experiment(
    name_or_path: str, overrides: Sequence[str] = (), without: Sequence[str] = ()
) -> tuple[Experiment, dict]:
    """The experiment shipped as `name`, or in the TOML file at a path, with `--set key.path=value` overrides applied.

    without: top-level tables to leave out. Returns the settings, and the plain table they came from for the run
    record. Raises ConfigError.
    """
    path = find_experiment(name_or_path)
    table = {"name": path.stem, **read_toml(path)}
    for override in overrides:
        apply_override(table, override)
    for key in without:
        table.pop(key, None)
    experiment = convert(table, Experiment, path.name)
    _check(experiment, path.name)
    return experiment, table


def find_experiment(name_or_path: str) -> Path:
    """The TOML file of an experiment: a path, or the name of a shipped one."""
    path = Path(name_or_path)
    if path.suffix == ".toml":
        if not path.is_file():
            raise ConfigError(f"{path}: no such experiment file; shipped ones are {', '.join(shipped())}")
        return path
    if name_or_path not in shipped():
        raise ConfigError(
            f"no experiment `{name_or_path}`; shipped ones are {', '.join(shipped())}, or give a path to a .toml file"
        )
    return EXPERIMENTS / f"{name_or_path}.toml"


def shipped() -> list[str]:
    """Names of the experiments that come with the package."""
    return sorted(p.stem for p in EXPERIMENTS.glob("*.toml"))


def read_toml(path: Path) -> dict:
    """The table in a TOML file; ConfigError in one line where it cannot be read."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ConfigError(f"{path}: not a readable TOML file: {error}") from error


def apply_override(table: dict, override: str) -> None:
    """Apply `key.path=value` to a nested table in place; the value is TOML, or else a string.

    An element of a list is named by its `name` or its index: `ekf.case.0.substeps=8`, `wls.WLS(3).decimation=5`.
    """
    key, equals, text = override.partition("=")
    if not equals or not key.strip():
        raise ConfigError(f"--set {override}: want key=value, for example ekf.substeps=8")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text.strip()
    *parents, last = key.strip().split(".")
    node: Any = table
    for part in parents:
        node = _child(node, part, override)
    if not isinstance(node, dict):
        raise ConfigError(f"--set {override}: `{'.'.join(parents)}` has no keys")
    node[last] = value


def _child(node: Any, part: str, override: str) -> Any:
    if isinstance(node, dict):
        return node.setdefault(part, {})
    if isinstance(node, list):
        for i, item in enumerate(node):
            if part == str(i) or (isinstance(item, dict) and item.get("name") == part):
                return item
    raise ConfigError(f"--set {override}: nothing is called `{part}` there")


def convert(table: dict, kind: type[Settings], where: str):
    """A table as a settings object of type `kind`; ConfigError names the file, the key and the nearest known key."""
    try:
        return msgspec.convert(copy.deepcopy(table), kind)
    except msgspec.ValidationError as error:
        raise ConfigError(f"{where}: {_explain(str(error), kind)}") from None


def _explain(message: str, kind: type[Settings]) -> str:
    unknown = re.search(r"unknown field `(.*?)`", message)
    if unknown is None:
        return message.replace(" - at `$.", " at `")
    near = get_close_matches(unknown[1], _field_names(kind), n=1, cutoff=0.6)
    place = re.search(r"at `\$\.(.*)`", message)
    hint = f"; did you mean `{near[0]}`?" if near else "; remove it"
    return f"unknown key `{unknown[1]}`{f' in `{place[1]}`' if place else ''}{hint}"


def _field_names(kind: Any, seen: set | None = None) -> set[str]:
    """Every key known anywhere below `kind`."""
    seen = set() if seen is None else seen
    info = msgspec.inspect.multi_type_info([kind])[0]
    names: set[str] = set()

    def walk(node: Any) -> None:
        if isinstance(node, msgspec.inspect.StructType):
            if node.cls in seen:
                return
            seen.add(node.cls)
            for item in node.fields:
                names.add(item.encode_name)
                walk(item.type)
        for attribute in ("item_type", "value_type"):
            if hasattr(node, attribute):
                walk(getattr(node, attribute))
        for part in getattr(node, "types", ()) or getattr(node, "item_types", ()):
            walk(part)

    walk(info)
    return names


def _check(experiment: Experiment, where: str) -> None:
    """What types alone cannot say; ConfigError."""
    names = [w.name for w in experiment.wls]
    if experiment.recommended not in names:
        raise ConfigError(f"{where}: recommended `{experiment.recommended}` is none of the WLS variants {names}")
    if experiment.simulation is None and experiment.data is None:
        raise ConfigError(f"{where}: no data: give [simulation] or [data]")
    for case in experiment.ekf.case if experiment.ekf else ():
        if bool(case.chi0) == (case.wls_factor is not None):
            raise ConfigError(f"{where}: {case.name}: give exactly one of chi0 and wls_factor")
        if [bool(case.P0_parameters), case.P0_relative is not None, case.P0_sigmas is not None].count(True) != 1:
            raise ConfigError(f"{where}: {case.name}: give exactly one of P0_parameters, P0_relative and P0_sigmas")
        if "paper" in case.tunings and not (case.R and case.Q):
            raise ConfigError(f"{where}: {case.name}: the tuning `paper` needs R and Q")
        if "known" in case.tunings and experiment.data is not None:
            raise ConfigError(f"{where}: {case.name}: the tuning `known` needs simulated data; use `derived`")
