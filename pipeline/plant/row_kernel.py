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


def _repeated(builder, number, widths):
    """Vectors of one number."""
    vectors = []
    for width in widths:
        nothing = ir.Constant(ir.VectorType(number.type, width), ir.Undefined)
        first = builder.insert_element(nothing, number, LANE(0))
        vectors.append(builder.shuffle_vector(first, nothing, ir.Constant(ir.VectorType(LANE, width), None)))
    return vectors


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


def _gathered(context, builder, kind, array, places):
    """A row of the entries at these places."""
    entries = iter([builder.load(_entry(context, builder, kind, array, *place)) for place in places])
    parts = []
    for width in Row(len(places)).widths:
        part = ir.Constant(_vector(width), ir.Undefined)
        for lane in range(width):
            part = builder.insert_element(part, next(entries), LANE(lane))
        parts.append(part)
    return cgutils.pack_struct(builder, parts)


@intrinsic
def column(typing, A, j):
    """Column j of A, as a row."""

    def generate(context, builder, signature, values):
        array, j = values
        return _gathered(context, builder, A, array, [(INDEX(i), j) for i in range(A.shape[0])])

    return Row(A.shape[0])(A, types.intp), generate


@intrinsic
def symmetric_row(typing, A, i):
    """Row i of the symmetric matrix of which A holds the lower triangle."""

    def generate(context, builder, signature, values):
        array, i = values
        places = []
        for j in map(INDEX, range(A.shape[1])):
            below = builder.icmp_signed("<", j, i)
            places.append((builder.select(below, i, j), builder.select(below, j, i)))
        return _gathered(context, builder, A, array, places)

    return Row(A.shape[1])(A, types.intp), generate


@intrinsic
def zero_row(typing, A):
    """A row of A's length, of zeros."""

    def generate(context, builder, signature, values):
        return ir.Constant(context.get_value_type(signature.return_type), None)

    return Row(A.shape[-1])(A), generate


@intrinsic
def unit_row(typing, value, i):
    """Row i of a unit lower triangular matrix that begins with the entries of a row."""

    def generate(context, builder, signature, values):
        parts, start = [], 0
        for part in cgutils.unpack_tuple(builder, values[0]):
            width = part.type.count
            place = ir.Constant(ir.VectorType(INDEX, width), [*range(start, start + width)])
            (here,) = _repeated(builder, values[1], [width])
            one, zero = (ir.Constant(_vector(width), [number] * width) for number in (1.0, 0.0))
            rest = builder.select(builder.icmp_signed("==", place, here), one, zero)
            parts.append(builder.select(builder.icmp_signed("<", place, here), part, rest))
            start += width
        return cgutils.pack_struct(builder, parts)

    return value(value, types.intp), generate


@intrinsic
def without_tiny(typing, value, tiny):
    """A row with 0 for its entries between −tiny and tiny."""

    def generate(context, builder, signature, values):
        parts, zero = [], ir.DoubleType()(0.0)
        limits = [_repeated(builder, number, value.widths) for number in (values[1], builder.fsub(zero, values[1]))]
        for part, high, low in zip(cgutils.unpack_tuple(builder, values[0]), *limits, strict=True):
            small = builder.and_(builder.fcmp_ordered("<", part, high), builder.fcmp_ordered(">", part, low))
            parts.append(builder.select(small, ir.Constant(part.type, None), part))
        return cgutils.pack_struct(builder, parts)

    return value(value, types.float64), generate


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
    return cgutils.unpack_tuple(builder, value) if kind == row else _repeated(builder, value, row.widths)


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.iadd, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _lower(_operation, _instruction)
