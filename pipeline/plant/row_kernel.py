"""Rows of matrices of constant size as values of compiled code: `t += a * row(P, j)` in place of a loop over columns.

Such a loop, its length a constant, is unrolled before it could be vectorised, and for all the compiler knows two
matrices might overlap. A row is kept in LLVM's vectors instead. Entries are computed each for itself: the bits do not
depend on the machine's width.
"""

from __future__ import annotations

import operator
from functools import partial

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

INDEX, LANE = ir.IntType(64), ir.IntType(32)


class Row(types.Type):
    """n doubles."""

    def __init__(self, n: int):
        self.n = n
        super().__init__(f"Row({n})")

    @property
    def widths(self) -> list[int]:
        """Of the vectors: powers of two, as only these stay whole from one block of code to the next."""
        return [4] * (self.n // 4) + [width for width in (2, 1) if self.n & width]


@register_model(Row)
class _RowModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, ir.LiteralStructType([_vector(width) for width in kind.widths]))


def _vector(width: int) -> ir.Type:
    return ir.VectorType(ir.DoubleType(), width)


def _entry(context, builder, kind, array, *index):
    """The address of an entry of an array."""
    return cgutils.get_item_pointer(context, builder, kind, context.make_array(kind)(context, builder, array), index)


def _parts(context, builder, kind, array, i, n):
    """The addresses of the vectors of row i of a matrix; a vector is the matrix's only row."""
    start, at = 0, []
    for width in Row(n).widths:
        index = (i, INDEX(start)) if kind.ndim == 2 else (INDEX(start),)
        at.append(builder.bitcast(_entry(context, builder, kind, array, *index), _vector(width).as_pointer()))
        start += width
    return at


@intrinsic
def row(typing, A, i):
    """Row i of A; of a vector, whatever i, all of it."""

    def generate(context, builder, signature, values):
        parts = _parts(context, builder, A, *values, A.shape[-1])
        return cgutils.pack_struct(builder, [builder.load(at, align=8) for at in parts])

    return Row(A.shape[-1])(A, types.intp), generate


@intrinsic
def set_row(typing, A, i, value):
    """Set row i of A or, by a shorter one, its beginning."""

    def generate(context, builder, signature, values):
        array, i, whole = values
        parts = _parts(context, builder, A, array, i, value.n)
        for part, at in zip(cgutils.unpack_tuple(builder, whole), parts, strict=True):
            builder.store(part, at, align=8)

    return types.void(A, types.intp, value), generate


@intrinsic
def column(typing, A, j):
    """Column j of A, as a row."""

    def generate(context, builder, signature, values):
        array, j = values
        parts, i = [], 0
        for width in Row(A.shape[0]).widths:
            part = ir.Constant(_vector(width), ir.Undefined)
            for lane in range(width):
                entry = builder.load(_entry(context, builder, A, array, INDEX(i), j))
                part = builder.insert_element(part, entry, LANE(lane))
                i += 1
            parts.append(part)
        return cgutils.pack_struct(builder, parts)

    return Row(A.shape[0])(A, types.intp), generate


@intrinsic
def zero_row(typing, A):
    """A row of A's length, of zeros."""

    def generate(context, builder, signature, values):
        return ir.Constant(context.get_value_type(signature.return_type), None)

    return Row(A.shape[-1])(A), generate


class _Elementwise(AbstractTemplate):
    """Between rows of one length, or a row and a number."""

    def generic(self, args, kws):
        rows = {kind for kind in args if isinstance(kind, Row)}
        if len(rows) == 1 and all(isinstance(kind, (Row, types.Float)) for kind in args):
            return signature(*rows, *args)
        return None


def _lower(operation, instruction: str) -> None:
    infer_global(operation)(type("_" + instruction, (_Elementwise,), {}))

    def generate(context, builder, signature, values):
        kind, compute = signature.return_type, getattr(builder, instruction)
        one, other = map(partial(_operand, builder, kind), signature.args, values)
        return cgutils.pack_struct(builder, [compute(a, b) for a, b in zip(one, other, strict=True)])

    for kinds in ((Row, Row), (types.Float, Row), (Row, types.Float)):
        lower_builtin(operation, *kinds)(generate)


def _operand(builder, row, kind, value):
    """The vectors of a row, or those of a number in every place."""
    if kind == row:
        return cgutils.unpack_tuple(builder, value)
    return [
        builder.shuffle_vector(
            builder.insert_element(ir.Constant(_vector(width), ir.Undefined), value, LANE(0)),
            ir.Constant(_vector(width), ir.Undefined),
            ir.Constant(ir.VectorType(LANE, width), None),
        )
        for width in row.widths
    ]


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.iadd, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _lower(_operation, _instruction)
