"""Derivatives of a model's functions: directional (forward mode) and adjoint (reverse mode), by CasADi.

Relations keep their values: they are arguments like the discrete variables, and nothing is differentiated by them.
"""

from __future__ import annotations

import casadi as ca

from pipeline.export.equations import Model, column


def sensitivities(model: Model) -> dict[str, tuple[list[ca.SX], list[ca.SX]]]:
    """{function: (seeds, results)} of the derivatives declared in wrapper/model.h; each takes the arguments first."""
    time, x, u, *_ = model.arguments()
    w = column([relation.indicator for relation in model.events.relations])
    known, seeds = ca.vertcat(time, x, u), [seed("time", time), seed("x", x), seed("u", u)]
    tangents = [tangent(value, known, ca.vertcat(*seeds)) for value in (model.derivatives, model.algebraics, w)]
    start_seeds, start_tangents = starting(model, w)
    return {
        "derivatives_tangent": (seeds, tangents[:1]),
        "algebraics_tangent": (seeds, tangents[1:]),
        "adjoint": transposed(seeds, tangents),
        "start_tangent": (start_seeds, start_tangents),
        "start_adjoint": transposed(start_seeds, start_tangents),
    }


def starting(model: Model, w: ca.SX) -> tuple[list[ca.SX], list[ca.SX]]:
    """Seeds of (t, p, x, z, u) and tangents of (calculated, x, z, derivatives, algebraics, w) in the initialisation.

    There the parameters are known and the start values that may be set; others may follow from them.
    """
    time, x, u, _, z, _ = model.arguments()
    p, calculated = model.symbols("constant", "parameter"), model.symbols("calculated")
    dt, dp, sx, sz, du = seeds = [seed(name, value) for name, value in zip("tpxzu", (time, p, x, z, u), strict=True)]
    dc = tangent(model.calculated, p, dp)
    known, direction = ca.vertcat(time, u, p, calculated), ca.vertcat(dt, du, dp, dc)
    given, given_direction = ca.vertcat(known, x, z), ca.vertcat(direction, sx, sz)
    dx, dz = (
        column(
            [
                own[i] if v.start is not None else tangent(model.starts[v.name], given, given_direction)
                for i, v in enumerate(model.variables[kind])
            ]
        )
        for kind, own in (("state", sx), ("discrete", sz))
    )
    known, direction = ca.vertcat(known, x, z), ca.vertcat(direction, dx, dz)
    rest = [tangent(value, known, direction) for value in (model.derivatives, model.algebraics, w)]
    return seeds, [dc, dx, dz, *rest]


def seed(name: str, value: ca.SX) -> ca.SX:
    """The symbols of a direction of `value`."""
    return ca.SX.sym(f"d_{name}", value.numel())


def tangent(value: ca.SX, known: ca.SX, direction: ca.SX) -> ca.SX:
    """∂value/∂known · direction (n, 1)."""
    if not value.numel() or not known.numel():
        return ca.SX.zeros(value.numel(), 1)
    return ca.densify(ca.jtimes(value, known, direction))


def transposed(seeds: list[ca.SX], tangents: list[ca.SX]) -> tuple[list[ca.SX], list[ca.SX]]:
    """The transpose of a map that is linear in its seeds: seeds of the tangents, results of the seeds' shapes."""
    weights = [seed(f"w{i}", value) for i, value in enumerate(tangents)]
    results = ca.SX.zeros(sum(s.numel() for s in seeds), 1)
    if any(value.numel() for value in tangents):
        results = ca.densify(ca.jtimes(ca.vertcat(*tangents), ca.vertcat(*seeds), ca.vertcat(*weights), True))
    ends = [0]
    for s in seeds:
        ends.append(ends[-1] + s.numel())
    return weights, [results[a:b] for a, b in zip(ends[:-1], ends[1:], strict=True)]
