"""Sorting: residual equations → every unknown as an expression of the knowns (block triangular form).

Blocks of several equations are solved together where they are linear in their unknowns, and refused where they are not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from pipeline.errors import ExportError
from pipeline.export.linear import is_definite, solve_linear


@dataclass(frozen=True)
class Equation:
    """A residual that is 0, and where it stands (`file:line` or "")."""

    residual: ca.SX
    place: str = ""


def solve(
    equations: list[Equation], unknowns: list[ca.SX], model: str, numbers: Mapping[str, float] | None = None
) -> list[ca.SX]:
    """Expressions of the unknowns (n,) in the knowns alone, from n residuals; ExportError where there are none.

    numbers: values of parameters by name, for which a system of equations may turn out to be definite.
    """
    if not unknowns and not equations:
        return []
    residuals = ca.vertcat(*[equation.residual for equation in equations])
    symbols = ca.vertcat(*unknowns)
    structure = ca.jacobian_sparsity(residuals, symbols)
    check_regular(structure, equations, unknowns, model)
    blocks, rows, columns, row_blocks, column_blocks, *_ = structure.btf()
    order, solutions = [], []
    for k in range(blocks):  # block lower triangular: the first block stands alone
        chosen = [unknowns[i] for i in sorted(columns[column_blocks[k] : column_blocks[k + 1]])]
        members = [equations[i] for i in sorted(rows[row_blocks[k] : row_blocks[k + 1]])]
        A, b = linear_system(members, chosen, model)
        definite = len(chosen) > 2 and is_definite(resolve(A, order, solutions), numbers or {})
        order += chosen
        solutions += solve_linear(A, b, definite)
    resolved, _ = ca.substitute_inplace(order, solutions, [])
    by_name = {symbol.name(): value for symbol, value in zip(order, resolved, strict=True)}
    return [by_name[symbol.name()] for symbol in unknowns]


def check_regular(structure: ca.Sparsity, equations: list[Equation], unknowns: list[ca.SX], model: str) -> None:
    """Refuse a system without a unique matching of equations and unknowns, naming what is left over."""
    n = len(unknowns)
    if len(equations) != n:
        raise ExportError(f"{model}: {len(equations)} equations for {n} unknowns")
    if ca.sprank(structure) == n:
        return
    dense = ca.DM(structure, 1).full()
    alone = [i for i in range(n) if not dense[i].any()]
    lost = [j for j in range(n) if not dense[:, j].any()]
    places = ", ".join(filter(None, (equations[i].place for i in alone)))
    names = ", ".join(unknowns[j].name() for j in lost)
    raise ExportError(
        f"{model}: structurally singular (rank {ca.sprank(structure)} of {n}): a DAE of higher index is not reduced; "
        f"state it with index 1{f'; equation without unknown: {places}' if places else ''}"
        f"{f'; undetermined: {names}' if names else ''}"
    )


def resolve(A: ca.SX, symbols: list[ca.SX], values: list[ca.SX]) -> ca.SX:
    """A with the values of what is solved already, each in those before it."""
    return ca.substitute_inplace(symbols, values, [A])[1][0] if symbols else A


def linear_system(members: list[Equation], unknowns: list[ca.SX], model: str) -> tuple[ca.SX, ca.SX]:
    """A (n, n) and b (n,) of one block, which must be linear in its own unknowns."""
    residual = ca.vertcat(*[member.residual for member in members])
    symbols = ca.vertcat(*unknowns)
    A = ca.jacobian(residual, symbols)
    if ca.depends_on(A, symbols):
        names = ", ".join(symbol.name() for symbol in unknowns)
        places = ", ".join(dict.fromkeys(member.place for member in members if member.place))
        raise ExportError(f"{model}: a non-linear system of equations cannot be exported: {names} ({places})")
    if A.is_constant() and np.linalg.matrix_rank(ca.DM(A).full()) < len(unknowns):
        names = ", ".join(symbol.name() for symbol in unknowns)
        raise ExportError(f"{model}: a singular system of equations: {names}")
    b = -ca.substitute(residual, symbols, ca.SX.zeros(len(unknowns)))
    return A, b
