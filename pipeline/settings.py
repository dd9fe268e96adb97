"""The settings of an experiment, as types: what its TOML file may say. An unknown key is refused."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
Count = Annotated[int, msgspec.Meta(ge=1)]
NotNegativeCount = Annotated[int, msgspec.Meta(ge=0)]
Substeps = Annotated[int, msgspec.Meta(ge=1, le=1000)]


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of every group of settings: frozen, and strict about its keys."""


class Filter(Settings):
    """A low-pass filter: Butterworth with `cutoff` [Hz] and `order`, or the usual decimation filter.

    "zero-phase" runs forward and backward, "forward" only forward (it lags), "none" passes the signal through;
    "decimate" is the 8th-order Chebyshev type I filter (0.05 dB, 0.8·Nyquist/decimation), forward and backward.
    Without `cutoff` a Butterworth takes it from the closed loop's bandwidth (pipeline/signals/cutoffs.py).
    """

    kind: Literal["zero-phase", "forward", "none", "decimate"]
    cutoff: Positive | None = None
    order: Count = 4


class WlsSettings(Settings):
    """How one WLS variant filters: the position, then y and every column of W in parallel, then 1 of `decimation`.

    Without `decimation`: the largest that keeps the decimated Nyquist frequency above the parallel cut-off. border:
    samples cut at the (beginning, end), counted at the original rate; half_sample: align the torque held over a
    sample with the position measured at its end.
    """

    name: str
    position: Filter
    parallel: Filter
    decimation: Count | None = None
    border: tuple[NotNegativeCount, NotNegativeCount] = (0, 0)
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

    sigma_q [rad or m], sigma_u [the plant input's unit]: one per joint; quantum_q [rad or m]: the encoders' steps, to
    which the noisy position is rounded (0, or none given: not); rate [Hz]; loop: "disturbed" (the noise acts in the
    loop) or "clean" (it stands in the record only).
    """

    identification: str
    validation: str
    rate: Positive
    truth: dict[str, float]
    sigma_q: tuple[NotNegative, ...]
    sigma_u: tuple[NotNegative, ...]
    quantum_q: tuple[NotNegative, ...] = ()
    loop: Literal["disturbed", "clean"] = "disturbed"


class ExcitationRun(Settings):
    """A trajectory's `segments` and how long each of them takes: `segment` [s]."""

    segments: Count
    segment: Positive


class ExcitationSettings(Settings):
    """What `fmuid excite` is to design: a trajectory from q = 0, at rest at both ends, within limits per joint.

    q, qd, qdd [rad or m, and s], tau [N.m or N]: largest sizes, of the plan and of the simulated closed loop;
    condition_number_W, condition_number_Phi: caps; sigma_tau [N.m or N]: the torque's noise per sample (default: that
    of [simulation], else 1); slow [qd's unit]: below half of it dry friction is not counted on to have its whole size,
    which makes the design turn round fast (default: 5 % of qd). The search: random `starts`, `iterations` of each
    stage, `grid` [Hz]: how finely the objective looks (limits are checked at 1 kHz). validation: the segments of the
    validation run, where they differ.
    """

    q: tuple[Positive, ...]
    qd: tuple[Positive, ...]
    qdd: tuple[Positive, ...]
    tau: tuple[Positive, ...]
    segments: Count = 20
    segment: Positive = 1.25
    condition_number_W: Positive | None = None
    condition_number_Phi: Positive | None = None
    sigma_tau: tuple[Positive, ...] = ()
    slow: tuple[Positive, ...] = ()
    starts: Count = 4
    iterations: Count = 60
    grid: Positive = 10.0
    validation: ExcitationRun | None = None


class Column(Settings):
    """One column of a measured file: its name and unit there; value = scale · (converted) + offset [our unit].

    The unit may be left to the file, where the column's heading is `name [unit]`.
    """

    source: str
    unit: str = ""
    scale: float = 1.0
    offset: float = 0.0


class DataSettings(Settings):
    """Measured data: the files, the frame's columns (`time`, `q_1`, `u_1`, `qr_1`, `pulse_1` …) and the rate [Hz].

    A column that the file itself heads `q_1 [rad]` needs no entry in `columns`; validation_columns come on top of
    them in the validation file; `pulse_i` feeds the controller's extra inputs in a re-simulation; delimiter and
    decimal: of CSV files, where they cannot be found from the file; `source` says where to get the files; `folder` is
    where they are, unless `--data` says otherwise.
    """

    identification: str
    validation: str
    rate: Positive
    columns: dict[str, Column] = {}
    validation_columns: dict[str, Column] = {}
    delimiter: Literal[",", ";", "\t", " "] | None = None
    decimal: Literal[".", ","] | None = None
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
    tunings: Annotated[tuple[Literal["paper", "known", "derived"], ...], msgspec.Meta(min_length=1)]
    chi0: tuple[float, ...] = ()
    wls_factor: float | None = None
    P0_state: tuple[Positive, ...] = ()
    P0_parameters: tuple[NotNegative, ...] = ()
    P0_relative: Positive | None = None
    P0_sigmas: Positive | None = None
    R: tuple[Positive, ...] = ()
    Q: tuple[NotNegative, ...] = ()
    method: Literal["euler", "rk4"] | None = None
    substeps: Substeps | None = None

    def called(self, tuning: str) -> str:
        """Name of the estimate: the paper's tuning, and one without an alternative, bear the case's bare name."""
        return self.name if len(self.tunings) == 1 or tuning == "paper" else f"{self.name} {tuning}"


class EkfSettings(Settings):
    """The extended Kalman filter: transition, Jacobian, covariance form and the cases to run.

    jacobian: by the FMU's directional derivatives where it has them, else by forward differences; or by differences.
    interface: "ME" integrates derivatives; "CS" steps from a restored FMU state, "CS reset" from a reset.
    P0_state (2n,): variances of [qd, q] at the start; start_at_rest: begin with qd = 0, else with the filtered
    velocity of the first sample; recommended: the estimate that the verdict judges.
    """

    P0_state: tuple[Positive, ...]
    case: tuple[EkfCase, ...]
    recommended: str = ""
    start_at_rest: bool = True
    method: Literal["euler", "rk4"] = "rk4"
    substeps: Substeps = 4
    interface: Literal["ME", "CS", "CS reset"] = "ME"
    jacobian: Literal["directional", "forward", "central"] = "directional"
    covariance: Literal["udu", "joseph"] = "udu"


class ClosedLoopSettings(Settings):
    """The re-simulation of the identified model in closed loop: which estimate, and the rows cut at both ends."""

    estimate: str
    border: tuple[NotNegativeCount, NotNegativeCount] = (0, 0)


class LimitSettings(Settings):
    """Limits of the verdict. Those with a default are always judged, the others where they are given."""

    condition_number_W: float = 1000.0
    condition_number_Phi: float | None = None
    relative_sigma_percent: float | None = None
    truth_sigmas: float | None = None
    force_error_percent: float = 30.0
    above_noise_floor_percent: float | None = None
    closed_loop_position_percent: float | None = None
    closed_loop_force_percent: float | None = None


class PublishedTable(Settings):
    """A published table: a column of values and relative sigmas [%] per estimate, and which of `ours` stands beside."""

    title: str
    columns: tuple[str, ...]
    ours: tuple[str, ...]
    parameters: tuple[str, ...]
    value: tuple[tuple[float, ...], ...]
    relative_sigma_percent: tuple[tuple[float, ...], ...]


class Reference(Settings):
    """Published results that ours are shown beside; all of it goes into the record.

    figures: which of our panels are the publication's figures; elapsed: seconds by method, and `machine`;
    force_error_percent and closed_loop: relative errors in % by run (and signal).
    """

    source: str = ""
    condition_number_W: float | None = None
    condition_number_Phi: float | None = None
    tables: tuple[PublishedTable, ...] = ()
    elapsed: dict[str, float | str] = {}
    force_error_percent: dict[str, float] = {}
    closed_loop: dict[str, dict[str, float]] = {}
    figures: dict[str, int | dict[str, tuple[int, ...]]] = {}


class Experiment(Settings):
    """A whole experiment: a plant (its binding), where the data come from, the estimators, the limits.

    Measured `data` come before `simulation` where an experiment has both; `recommended` names the WLS variant that
    everything else builds on; `reference` holds published results and goes into the record as it is; `fmi` is the
    version of plant and controller, where they are FMUs of ours; `engine` computes filters, regressor and closed loop
    ("filterpy": the filters' covariance, and the rest in Python).
    """

    name: str
    title: str
    plant: str
    wls: tuple[WlsSettings, ...]
    recommended: str
    controller: ControllerSettings | None = None
    fmi: Literal["2", "3"] = "2"
    engine: Literal["compiled", "python", "filterpy"] = "compiled"
    seed: NotNegativeCount = 0
    simulation: SimulationSettings | None = None
    data: DataSettings | None = None
    excitation: ExcitationSettings | None = None
    ekf: EkfSettings | None = None
    closed_loop: ClosedLoopSettings | None = None
    limits: LimitSettings = LimitSettings()
    reference: Reference = Reference()
