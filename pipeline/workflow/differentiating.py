"""Which Jacobian the filter gets: the one asked for, checked against another before a filter runs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from pipeline.errors import FmuError
from pipeline.identify.jacobian import AGREED, Point, disagreement, everything
from pipeline.plant.plant import open_plant
from pipeline.signals.frames import joint_columns
from pipeline.workflow.batch import Batch
from pipeline.workflow.session import Session

POINTS = 10


@dataclass(frozen=True)
class JacobianChoice:
    """How a filter's Jacobian is computed: `used`, and how far it is from `against`, another way (`disagreement`).

    difference: None where it could not be had; reason: why it is not what was asked for, or not known to be right;
    all_columns: whether even those are differenced that make no difference by the FMU's own word, which is wrong.
    """

    used: str
    against: str
    difference: float | None
    reason: str = ""
    all_columns: bool = False

    @property
    def text(self) -> str:
        """One line for people."""
        words = {
            "directional": "directional derivatives of the FMU",
            "forward": "forward differences",
            "central": "central differences",
        }
        apart = "not compared with" if self.difference is None else f"{self.difference:.1e} from"
        return f"{words[self.used]}, {apart} {words[self.against]}{f' ({self.reason})' if self.reason else ''}"

    @property
    def doubt(self) -> str:
        """Why a sigma that rests on this Jacobian must not be trusted, or ""."""
        if self.difference is None:
            return f"the Jacobian by {self.used} could be compared with no other"
        if self.difference <= AGREED:
            return ""
        return f"the Jacobian by {self.used} differences is {self.difference:.1e} from that by {self.against} ones"


def choose_jacobian(
    session: Session, best: Batch, interface: str, method: str, substeps: int, engine: str = "python"
) -> JacobianChoice:
    """The Jacobian for these transitions by this engine, checked at POINTS of the filtered motion.

    Directional derivatives give way to forward differences where the FMU has none, or where they are wrong.
    """
    wanted, points = session.experiment.ekf.jacobian, points_of(session, best)
    opened = partial(open_plant, session.binding, "filter", interface, method, substeps, engine)
    with opened() as plant:
        if wanted == "directional" and not plant.directional:
            what = "the FMU provides none" if interface == "ME" else "by Co-Simulation there are none of a step"
            return _compared(plant, points, "forward", f"directional ones were asked for; {what}")
        choice = _compared(plant, points, wanted)
    if wanted != "directional" or (choice.difference is not None and choice.difference <= AGREED):
        return choice
    apart = "cannot be had" if choice.difference is None else f"are {choice.difference:.1e} off"
    with opened() as plant:  # anew: an instance that gave an error is not to be used on
        return _compared(plant, points, "forward", f"the FMU's directional derivatives {apart} {choice.reason}".strip())


def _compared(plant, points: list[Point], mode: str, reason: str = "") -> JacobianChoice:
    against = "forward" if mode == "central" else "central"
    try:
        difference = disagreement(plant, points, mode, against)
        if mode == "directional" or difference <= AGREED:
            return JacobianChoice(mode, against, difference, reason)
        plant.columns = everything(plant)
        whole = disagreement(plant, points, mode, against)
    except FmuError as error:
        return JacobianChoice(mode, against, None, f"{reason}; {error}" if reason else str(error))
    if whole > AGREED:
        return JacobianChoice(mode, against, difference, reason)
    more = "what the FMU says of the dependencies of its derivatives is wrong: all columns are differenced"
    return JacobianChoice(mode, against, whole, f"{reason}; {more}" if reason else more, all_columns=True)


def points_of(session: Session, best: Batch) -> list[Point]:
    """POINTS of the filtered motion, with the parameters of WLS, or a priori where it held them."""
    n, frame = session.binding.n, best.filtered
    chi = session.binding.a_priori
    for name, value in zip(best.estimate.names, best.estimate.theta, strict=True):
        chi[session.binding.names.index(name)] = value
    rows = np.linspace(0, len(frame) - 2, POINTS + 2).astype(int)[1:-1]
    time = frame.index.to_numpy(dtype=float)
    q, qd, u = (frame[joint_columns(c, n)].to_numpy() for c in ("q", "qd", "u"))
    return [Point(np.concatenate([qd[k], q[k]]), chi, u[k], time[k], time[k + 1] - time[k]) for k in rows]
