"""Vectors of eight numbers, double or single: the instructions of the loops in solvers.sparse_lu.dense_front.

`load`, `store` and `minus` stand for LLVM instructions, which are compiled for the present machine, into several narrower ones
if it has none of this width. Vectors that are not full are loaded and stored under a mask. The bodies in Python define the
meaning, and run if compilation is disabled. A multiplication and an addition may be fused, with a single rounding; all sums are
in the order written here.

The gain over the same factorisation with plain loops is measured by tests/benchmarks/test_sparse_lu.py: none where fronts are
narrow (stacks), a factor of 2 on planar pyramids of 40 rows, and of 4 on pyramids of spheres.

Kernels depend on this file. frictionbench.problems.compiled is named here so that the hash of all kernel files includes it.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing import signature
from numba.extending import lower_builtin, models, register_model, type_callable

from frictionbench.problems.check import Array

LANES = 8  # doubles in a register of AVX-512; narrower machines use two or four registers, with the same order of sums


def load(F: Array, i: int, j: int, n: int) -> Array:
    """A vector of F[i, j : j + n], n at most 8, and zeros."""
    vector = np.zeros(LANES, F.dtype)
    vector[:n] = F[i, j : j + n]
    return vector


def store(F: Array, i: int, j: int, n: int, vector: Array) -> None:
    """F[i, j : j + n] = vector[:n]."""
    F[i, j : j + n] = vector[:n]


def minus(vector: Array, a: float, other: Array) -> Array:
    """vector - a other."""
    return vector - a * other


class _Vector(types.Type):
    """numba's type of a vector. number: the type of its entries."""

    def __init__(self, number: Any) -> None:
        super().__init__(f"vector of {number}")
        self.number = number

    @property
    def lanes(self) -> Any:
        """The LLVM type."""
        return ir.VectorType(ir.DoubleType() if self.number == types.float64 else ir.FloatType(), LANES)


_BITS, _INDICES, _WORD = ir.VectorType(ir.IntType(1), LANES), ir.VectorType(ir.IntType(64), LANES), ir.IntType(32)


@register_model(_Vector)
class _Register(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, kind.lanes)


@type_callable(load)
def _type_of_load(_: Any) -> Any:
    return lambda F, i, j, n: signature(_Vector(F.dtype), F, types.intp, types.intp, types.intp)


@type_callable(store)
def _type_of_store(_: Any) -> Any:
    return lambda F, i, j, n, vector: signature(types.void, F, types.intp, types.intp, types.intp, vector)


@type_callable(minus)
def _type_of_minus(_: Any) -> Any:
    return lambda vector, a, other: signature(vector, vector, vector.number, other)


def _all_lanes(builder: Any, value: Any, kind: Any) -> Any:
    nothing = ir.Constant(kind, ir.Undefined)
    one = builder.insert_element(nothing, value, _WORD(0))
    return builder.shuffle_vector(one, nothing, ir.Constant(ir.VectorType(_WORD, LANES), [0] * LANES))


def _place(context: Any, builder: Any, kind: Any, F: Any, i: Any, j: Any, n: Any) -> tuple[Any, Any, Any, str]:
    """The address of F[i, j], its alignment (a number's size), the mask of the first n lanes, and LLVM's name of the vector."""
    matrix = context.make_array(kind)(context, builder, F)
    columns = builder.extract_value(matrix.shape, 1)
    at = builder.gep(matrix.data, [builder.add(builder.mul(i, columns), j)])
    mask = builder.icmp_signed("<", ir.Constant(_INDICES, list(range(LANES))), _all_lanes(builder, n, _INDICES))
    bits = kind.dtype.bitwidth
    return builder.bitcast(at, _Vector(kind.dtype).lanes.as_pointer()), _WORD(bits // 8), mask, f"v{LANES}f{bits}"


@lower_builtin(load, types.Array, types.intp, types.intp, types.intp)
def _emit_load(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    at, aligned, mask, name = _place(context, builder, signature.args[0], *arguments)
    lanes = signature.return_type.lanes
    kind = ir.FunctionType(lanes, [at.type, _WORD, _BITS, lanes])
    instruction = cgutils.get_or_insert_function(builder.module, kind, f"llvm.masked.load.{name}.p0")
    return builder.call(instruction, [at, aligned, mask, ir.Constant(lanes, [0.0] * LANES)])


@lower_builtin(store, types.Array, types.intp, types.intp, types.intp, _Vector)
def _emit_store(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    at, aligned, mask, name = _place(context, builder, signature.args[0], *arguments[:4])
    kind = ir.FunctionType(ir.VoidType(), [signature.args[4].lanes, at.type, _WORD, _BITS])
    instruction = cgutils.get_or_insert_function(builder.module, kind, f"llvm.masked.store.{name}.p0")
    builder.call(instruction, [arguments[4], at, aligned, mask])
    return context.get_dummy_value()


@lower_builtin(minus, _Vector, types.Float, _Vector)
def _emit_minus(_: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    vector, a, other = arguments
    product = builder.fmul(_all_lanes(builder, a, signature.args[0].lanes), other, flags=("contract",))
    return builder.fsub(vector, product, flags=("contract",))
