"""Sorting: residual equations → every unknown as an expression of the knowns (block triangular form).

Blocks of several equations are solved together where they are linear in their unknowns, and refused where they are not.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from pipeline.errors import ExportError


@dataclass(frozen=True)
class Equation:
    """A residual that is 0, and where it stands (`file:line` or "")."""

    residual: ca.SX
    place: str = ""


def solve(equations: list[Equation], unknowns: list[ca.SX], model: str) -> list[ca.SX]:
    """Expressions of the unknowns (n,) in the knowns alone, from n residuals; ExportError where there are none."""
    if not unknowns and not equations:
        return []
    residuals = ca.vertcat(*[equation.residual for equation in equations])
    symbols = ca.vertcat(*unknowns)
    structure = ca.jacobian_sparsity(residuals, symbols)
    check_regular(structure, equations, unknowns, model)
    blocks, rows, columns, row_blocks, column_blocks, *_ = structure.btf()
    order, solutions = [], []
    for k in range(blocks):  # block lower triangular: the first block stands alone
        chosen = columns[column_blocks[k] : column_blocks[k + 1]]
        members = [equations[i] for i in rows[row_blocks[k] : row_blocks[k + 1]]]
        order += [unknowns[i] for i in chosen]
        solutions += solve_block(members, [unknowns[i] for i in chosen], model)
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


def solve_block(members: list[Equation], unknowns: list[ca.SX], model: str) -> list[ca.SX]:
    """Solve one block, linear in its own unknowns."""
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
    if len(unknowns) == 1:
        return [b / A]
    if len(unknowns) == 2:
        return cramer(A, b)
    return ca.vertsplit(ca.solve(ca.densify(A), b))


def cramer(A: ca.SX, b: ca.SX) -> list[ca.SX]:
    """The solution of two equations, in fewer operations than any factorisation."""
    det = A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    return [(A[1, 1] * b[0] - A[0, 1] * b[1]) / det, (A[0, 0] * b[1] - A[1, 0] * b[0]) / det]
