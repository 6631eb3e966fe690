"""Dense blocks of a row-major matrix, eight numbers at a time.

A - B C with its sums kept in vector registers: a tile of A, four rows by two vectors of eight, is read once, takes up a row of
C for each column of B, and is written once, so that nearly every instruction multiplies and adds. The compiler does not find
this form by itself: of plain loops over numbers it makes code several times slower, the more so for the few columns that do not
fill a vector, which it takes one by one; here they are the same instruction under a mask. So `load`, `store` and `minus` stand
for instructions of LLVM, which turns them into those of the machine at hand, several narrower ones where it has none so wide.
Their bodies in Python say what they do, and are what runs where numba is told to compile nothing. A difference and its product
may be rounded together, once; no sum is reordered.

Reference: Goto and van de Geijn 2008 (sums in registers).
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, models, register_model, type_callable

from problems.check import Array
from problems.compiled import inlined, part

LANES = 8


def load(F: Array, i: int, j: int, n: int) -> Array:
    """F[i, j : j + n] for n up to 8: a vector."""
    return F[i, j : j + n].copy()


def store(F: Array, i: int, j: int, n: int, vector: Array) -> None:
    """F[i, j : j + n] = vector."""
    F[i, j : j + n] = vector


def minus(vector: Array, a: float, other: Array) -> Array:
    """vector - a other."""
    return vector - a * other


@part
def subtract_product(F: Array, top: int, bottom: int, left: int, right: int, begin: int, end: int) -> None:
    """F[top:bottom, left:right] -= F[top:bottom, begin:end] F[begin:end, left:right]."""
    for j in range(left, right, 2 * LANES):
        m, n, o = min(LANES, right - j), max(0, min(LANES, right - j - LANES)), j + LANES
        i = top
        while i + 4 <= bottom:
            a, b, c, d = load(F, i, j, m), load(F, i + 1, j, m), load(F, i + 2, j, m), load(F, i + 3, j, m)
            e, f, g, h = load(F, i, o, n), load(F, i + 1, o, n), load(F, i + 2, o, n), load(F, i + 3, o, n)
            for k in range(begin, end):
                x, y = load(F, k, j, m), load(F, k, o, n)
                a, e = minus(a, F[i, k], x), minus(e, F[i, k], y)
                b, f = minus(b, F[i + 1, k], x), minus(f, F[i + 1, k], y)
                c, g = minus(c, F[i + 2, k], x), minus(g, F[i + 2, k], y)
                d, h = minus(d, F[i + 3, k], x), minus(h, F[i + 3, k], y)
            _store_pair(F, i, j, m, a, n, e)
            _store_pair(F, i + 1, j, m, b, n, f)
            _store_pair(F, i + 2, j, m, c, n, g)
            _store_pair(F, i + 3, j, m, d, n, h)
            i += 4
        while i < bottom:
            a, e = load(F, i, j, m), load(F, i, o, n)
            for k in range(begin, end):
                a, e = minus(a, F[i, k], load(F, k, j, m)), minus(e, F[i, k], load(F, k, o, n))
            _store_pair(F, i, j, m, a, n, e)
            i += 1


@inlined
def _store_pair(F: Array, i: int, j: int, m: int, left: Array, n: int, right: Array) -> None:
    store(F, i, j, m, left)
    store(F, i, j + LANES, n, right)


class _Vector(types.Type):
    """numba's type of a vector."""


_VECTOR = _Vector("vector")
_DOUBLES, _BITS = ir.VectorType(ir.DoubleType(), LANES), ir.VectorType(ir.IntType(1), LANES)
_INDICES, _WORD = ir.VectorType(ir.IntType(64), LANES), ir.IntType(32)
_ALIGNED = _WORD(8)  # as a number is


@register_model(_Vector)
class _Register(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _DOUBLES)


@type_callable(load)
def _type_of_load(_: Any) -> Any:
    return lambda F, i, j, n: _VECTOR(F, types.intp, types.intp, types.intp)


@type_callable(store)
def _type_of_store(_: Any) -> Any:
    return lambda F, i, j, n, vector: types.void(F, types.intp, types.intp, types.intp, vector)


@type_callable(minus)
def _type_of_minus(_: Any) -> Any:
    return lambda vector, a, other: _VECTOR(vector, types.float64, other)


def _all_lanes(builder: Any, value: Any, kind: Any) -> Any:
    nothing = ir.Constant(kind, ir.Undefined)
    one = builder.insert_element(nothing, value, _WORD(0))
    return builder.shuffle_vector(one, nothing, ir.Constant(ir.VectorType(_WORD, LANES), [0] * LANES))


def _place(context: Any, builder: Any, kind: Any, F: Any, i: Any, j: Any, n: Any) -> tuple[Any, Any]:
    """Where F[i, j] lies, and which lanes come before the n-th."""
    matrix = context.make_array(kind)(context, builder, F)
    columns = builder.extract_value(matrix.shape, 1)
    at = builder.gep(matrix.data, [builder.add(builder.mul(i, columns), j)])
    mask = builder.icmp_signed("<", ir.Constant(_INDICES, list(range(LANES))), _all_lanes(builder, n, _INDICES))
    return builder.bitcast(at, _DOUBLES.as_pointer()), mask


@lower_builtin(load, types.Array, types.intp, types.intp, types.intp)
def _emit_load(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    at, mask = _place(context, builder, signature.args[0], *arguments)
    kind = ir.FunctionType(_DOUBLES, [at.type, _WORD, _BITS, _DOUBLES])
    instruction = cgutils.get_or_insert_function(builder.module, kind, "llvm.masked.load.v8f64.p0")
    return builder.call(instruction, [at, _ALIGNED, mask, ir.Constant(_DOUBLES, [0.0] * LANES)])


@lower_builtin(store, types.Array, types.intp, types.intp, types.intp, _Vector)
def _emit_store(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    at, mask = _place(context, builder, signature.args[0], *arguments[:4])
    kind = ir.FunctionType(ir.VoidType(), [_DOUBLES, at.type, _WORD, _BITS])
    instruction = cgutils.get_or_insert_function(builder.module, kind, "llvm.masked.store.v8f64.p0")
    builder.call(instruction, [arguments[4], at, _ALIGNED, mask])
    return context.get_dummy_value()


@lower_builtin(minus, _Vector, types.float64, _Vector)
def _emit_minus(_: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    vector, a, other = arguments
    product = builder.fmul(_all_lanes(builder, a, _DOUBLES), other, flags=("contract",))
    return builder.fsub(vector, product, flags=("contract",))
