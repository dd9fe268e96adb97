"""Plants in Python with the seam's face, for tests of the filter that need no FMU."""

from types import SimpleNamespace

import numpy as np

from pipeline.errors import FmuError


class LinearPlant:
    """One joint, s⁺ = A s + B u + E chi exactly: the parameter chi (1,) is a constant load."""

    n, ns, compiled, columns = 1, 2, False, range(4)
    binding = SimpleNamespace(gain=np.ones(1), u_range=np.ones(1), scale=np.ones(1))

    def __init__(self, dt=0.01, fails_at=None):
        self.A = np.array([[0.98, 0.0], [dt, 1.0]])
        self.B = np.array([[dt], [0.5 * dt**2]])
        self.E = np.array([[0.3 * dt], [0.0]])
        self.fails_at, self.calls = fails_at, 0

    def transition(self, s, u, chi, t, dt):
        """The next state; a constant load chi is estimated beside it. FmuError from `fails_at` on."""
        self.calls += 1
        if self.fails_at is not None and t >= self.fails_at:
            raise FmuError("linear.fmu: fmi2DoStep returned Error")
        return self.A @ s + self.B @ u + self.E @ chi
