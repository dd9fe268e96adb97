"""What every compiled kernel is made with: the decorator, calls of C functions by address, arrays by address.

A kernel runs without the interpreter's lock. Machine code is kept on disk, in a folder named by the text of all
kernels: numba itself looks at the file of the outermost one only, and would go on with an inner one that has changed.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256

import numba
import numpy as np
from llvmlite import ir
from numba import carray, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from pipeline.paths import PACKAGE, kernel_cache


def fingerprint() -> str:
    """What the text of every file of kernels, and of that with their constants, comes to: 16 hex digits."""
    files = [*sorted(PACKAGE.glob("*/*kernel.py")), PACKAGE / "plant" / "fmu.py"]
    text = b"".join(file.read_bytes() for file in files)
    return sha256(text + numba.__version__.encode()).hexdigest()[:16]


_folder = kernel_cache(fingerprint())
if _folder is not None:
    numba.config.CACHE_DIR = str(_folder)

_compile = njit(nogil=True, cache=_folder is not None, error_model="numpy", forceinline=True)
_listeners: list[Callable[[], None]] = []
_heard: list[Callable[[], None]] = []


def kernel(function: Callable) -> Callable:
    """Decorator: compile for the types it is called with, as NumPy computes (x/0 is inf), no operations reordered."""
    dispatcher = _compile(function)
    if not numba.config.DISABLE_JIT:
        dispatcher._cache = _Kept(dispatcher._cache)
    return dispatcher


def compiles(listener: Callable[[], None]) -> None:
    """Compile the smallest kernel, or load it; raises whatever stops numba or LLVM on this machine.

    listener: called before anything else is compiled that is not kept from an earlier run; one of a process only.
    """
    if numba.config.DISABLE_JIT:
        raise RuntimeError("NUMBA_DISABLE_JIT is set")
    _listeners.clear()
    _one()
    if not _heard:
        _listeners.append(listener)


class _Kept:
    """numba's cache of a kernel: what is damaged in it is compiled again, and a full disk keeps nothing."""

    def __init__(self, cache):
        self._cache = cache

    def __getattr__(self, name: str):
        return getattr(self._cache, name)

    def load_overload(self, signature, context):
        """The machine code for a signature, or None."""
        try:
            found = self._cache.load_overload(signature, context)
        except Exception:  # a file that another hand, or a full disk, has spoilt gives any
            found = None
        if found is None and _listeners:
            _heard.append(_listeners.pop())
            _heard[-1]()
        return found

    def save_overload(self, signature, data) -> None:
        """Keep machine code, if need be in place of an index that cannot be read."""
        try:
            self._cache.save_overload(signature, data)
        except Exception:
            with suppress(Exception):
                self._cache.flush()
                self._cache.save_overload(signature, data)


@intrinsic
def call(typing, address, *arguments):
    """The int (32 bits) that the C function at address gives for arguments: integers and addresses int64, or float64.

    C's int, bool and size_t all travel in whole registers, so int64 serves for each.
    """
    kinds = arguments[0] if len(arguments) == 1 and isinstance(arguments[0], types.BaseTuple) else arguments
    signature = types.int32(address, types.Tuple(kinds))

    def generate(context, builder, signature, values):
        arguments = cgutils.unpack_tuple(builder, values[1])
        function = ir.FunctionType(ir.IntType(32), [argument.type for argument in arguments])
        return builder.call(builder.inttoptr(values[0], function.as_pointer()), arguments)

    return signature, generate


def _pointer(kind: types.Type, width: ir.Type):
    @intrinsic
    def pointer(typing, address):
        def generate(context, builder, signature, values):
            return builder.inttoptr(values[0], width.as_pointer())

        return types.CPointer(kind)(address), generate

    return pointer


_doubles, _integers, _bytes = (
    _pointer(kind, width)
    for kind, width in (
        (types.float64, ir.DoubleType()),
        (types.int64, ir.IntType(64)),
        (types.uint8, ir.IntType(8)),
    )
)


@kernel
def array_at(address, n):
    """The n doubles at address: a view that owns nothing."""
    return carray(_doubles(address), n)


@kernel
def address(array):
    """Where a contiguous array begins."""
    return np.int64(array.ctypes.data)


@kernel
def matrix_at(address, rows, columns):
    """The (rows, columns) doubles at address."""
    return carray(_doubles(address), (rows, columns))


@kernel
def integers_at(address, n):
    """The n int64 at address."""
    return carray(_integers(address), n)


@kernel
def bytes_at(address, n):
    """The n bytes at address."""
    return carray(_bytes(address), n)


@kernel
def _one():
    return 1
