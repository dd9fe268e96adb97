"""What a plant FMU must be for states to be set by hand: positions and velocities, no other state, no branches."""

from __future__ import annotations

import numpy as np
from fmpy.model_description import ModelVariable

from pipeline.errors import FmuError
from pipeline.plant.binding import Binding
from pipeline.plant.fmu import Fmu


def states_of(file: Fmu) -> list[ModelVariable]:
    """The continuous states in the FMU's order."""
    return [unknown.variable.derivative for unknown in file.description.derivatives]


def state_order(file: Fmu, binding: Binding) -> tuple[np.ndarray, int]:
    """Where the continuous states of the FMU stand in [qd, q] (2n,), and their number. Hidden states are refused."""
    index = {variable.name: i for i, variable in enumerate(states_of(file))}
    wanted = [j.velocity_state or j.velocity for j in binding.joint]
    wanted += [j.position_state or j.position for j in binding.joint]
    for name in wanted:
        if name not in index:
            raise FmuError(
                f"{file.path.name}: `{name}` is no continuous state; they are {', '.join(index)}: "
                "name one as position_state or velocity_state in the binding"
            )
    hidden = [name for name in index if name not in wanted]
    if hidden:
        raise FmuError(
            f"{file.path.name}: besides positions and velocities it has the states {', '.join(hidden)}; plants with "
            "hidden states are not handled yet: export one without them"
        )
    return np.array([index[name] for name in wanted]), len(index)


def refuse_events(file: Fmu) -> None:
    """A relation keeps its branch between events (FMI 2.0.5, §3.1), so a state set by hand may be in the wrong one."""
    count = file.description.numberOfEventIndicators or 0
    if count:
        raise FmuError(
            f"{file.path.name}: {count} event indicators: its equations have branches that a filter cannot follow; "
            "write them smoothly, for example sign(qd) as tanh(qd/eps)"
        )


def influential(file: Fmu, binding: Binding) -> np.ndarray:
    """The places in [s, chi, u] that the transition depends on, by the FMU's own word; all, where it says nothing.

    A state that no derivative depends on only moves by itself: its column is the identity's (FMI 2.0.5, §2.2.8; 3.0.2,
    §2.4.9). Of parameters the dependencies do not speak.
    """
    states = [j.velocity_state or j.velocity for j in binding.joint]
    states += [j.position_state or j.position for j in binding.joint]
    names = [*states, *[None] * len(binding.parameter), *(j.input for j in binding.joint)]
    derivatives = file.description.derivatives
    if not derivatives or any(unknown.dependencies is None for unknown in derivatives):
        return np.arange(len(names))
    used = {variable.name for unknown in derivatives for variable in unknown.dependencies}
    return np.array([i for i, name in enumerate(names) if name is None or name in used])
