"""Eight numbers at once, for the kernels whose speed must not depend on what a compiler sees in a loop.

:class:`Lanes` is a type of compiled code only: numba's compiler keeps it in one register of the widest processors, in
several of others. ``+ - * /`` work lane by lane. Loads check their range where numba checks indices.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import binding, ir
from numba.core import cgutils, types
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

COUNT = 8
"""Numbers in a :class:`Lanes`."""
COMPRESSES = binding.get_host_cpu_features().get("avx512vl", False)
"""Whether this processor moves the lanes that are wanted to the front in one instruction."""
_DOUBLES = ir.VectorType(ir.DoubleType(), COUNT)
_LONGS = ir.VectorType(ir.IntType(64), COUNT)
_POINTERS = ir.VectorType(ir.DoubleType().as_pointer(), COUNT)
_BYTES = ir.VectorType(ir.IntType(8), COUNT)
_BITS = ir.VectorType(ir.IntType(1), COUNT)
_INDICES = ir.VectorType(ir.IntType(32), COUNT)
_INT = ir.IntType(32)
_instructions: Any = intrinsic
"""Makes a function of a generator of instructions; numba's annotations lack that it takes the type context away."""


class Lanes(types.Type):
    """Eight doubles."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


_LANES = Lanes()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _DOUBLES)


def _operation(symbol: Callable[..., Any], instruction: str) -> None:
    """Let an operator work on lanes."""

    @infer_global(symbol)
    class _Typing(AbstractTemplate):
        def generic(self, args, _keywords):
            return signature(_LANES, *args) if args == (_LANES, _LANES) else None

    @lower_builtin(symbol, Lanes, Lanes)
    def _lower(_context, builder, _signature, args):
        return getattr(builder, instruction)(*args)


_operation(operator.add, "fadd")
_operation(operator.sub, "fsub")
_operation(operator.mul, "fmul")
_operation(operator.truediv, "fdiv")


def _address(context: Any, builder: Any, kind: Any, array: Any, index: Any, item: ir.Type) -> Any:
    """Where eight numbers of an array begin, checked if numba checks indices."""
    struct = context.make_array(kind)(context, builder, value=array)
    if context.enable_boundscheck:
        size = builder.extract_value(struct.shape, 0)
        for wanted in (index, builder.add(index, index.type(COUNT - 1))):
            cgutils.do_boundscheck(context, builder, wanted, size, 0)
    return builder.bitcast(builder.gep(struct.data, [index]), item.as_pointer())


def _in_all(builder: Any, value: Any, kind: ir.VectorType) -> Any:
    """One value in all lanes of a vector type."""
    one = builder.insert_element(ir.Constant(kind, ir.Undefined), value, _INT(0))
    return builder.shuffle_vector(one, one, ir.Constant(_INDICES, [0] * COUNT))


@_instructions
def spread(_typing, value):
    """One number in all lanes."""

    def generate(_context, builder, _signature, args):
        return _in_all(builder, args[0], _DOUBLES)

    return _LANES(types.float64), generate


@_instructions
def load(_typing, row, index):
    """Eight numbers of a contiguous row, from an index on."""

    def generate(context, builder, signature, args):
        begin = builder.zext(args[1], ir.IntType(64)) if args[1].type.width < 64 else args[1]
        return builder.load(_address(context, builder, signature.args[0], args[0], begin, _DOUBLES), align=8)

    return _LANES(row, index), generate


@_instructions
def gather(_typing, row, indices, index):
    """Eight numbers of a contiguous row from all over it: those that eight ``indices`` (uint32), from an index of
    theirs on, say.
    """

    def generate(context, builder, signature, args):
        row, indices, index = args
        kind, listed = signature.args[:2]
        begin = builder.zext(index, ir.IntType(64)) if index.type.width < 64 else index
        where = builder.load(_address(context, builder, listed, indices, begin, _INDICES), align=4)
        struct = context.make_array(kind)(context, builder, value=row)
        if context.enable_boundscheck:
            size = builder.extract_value(struct.shape, 0)
            for lane in range(COUNT):
                wanted = builder.zext(builder.extract_element(where, _INT(lane)), ir.IntType(64))
                cgutils.do_boundscheck(context, builder, wanted, size, 0)
        base = _in_all(builder, builder.ptrtoint(struct.data, ir.IntType(64)), _LONGS)
        far = builder.shl(builder.zext(where, _LONGS), ir.Constant(_LONGS, [3] * COUNT))
        places = builder.inttoptr(builder.add(base, far), _POINTERS)
        take = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(_DOUBLES, [_POINTERS, _INT, _BITS, _DOUBLES]),
            "llvm.masked.gather.v8f64.v8p0",
        )  # fmt: skip
        every = ir.Constant(_BITS, [1] * COUNT)
        return builder.call(take, [places, _INT(8), every, ir.Constant(_DOUBLES, ir.Undefined)])

    return _LANES(row, indices, index), generate


@_instructions
def mask_set(_typing, row, index):
    """Which of eight bytes of a contiguous row, from an index on, are not 0: bit k of an integer for lane k."""

    def generate(context, builder, signature, args):
        begin = builder.zext(args[1], ir.IntType(64)) if args[1].type.width < 64 else args[1]
        these = builder.load(_address(context, builder, signature.args[0], args[0], begin, _BYTES), align=1)
        found = builder.icmp_unsigned("!=", these, ir.Constant(_BYTES, [0] * COUNT))
        return builder.zext(builder.bitcast(found, ir.IntType(COUNT)), ir.IntType(64))

    return types.uint64(row, index), generate


@_instructions
def store(_typing, row, index, values):
    """Write eight numbers into a contiguous row, from an index on."""

    def generate(context, builder, signature, args):
        builder.store(args[2], _address(context, builder, signature.args[0], args[0], args[1], _DOUBLES), align=8)
        return context.get_dummy_value()

    return types.void(row, types.uint64, values), generate


@_instructions
def square_root(_typing, values):
    """Of each lane."""

    def generate(_context, builder, _signature, args):
        root = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_DOUBLES, [_DOUBLES]), "llvm.sqrt.v8f64")
        return builder.call(root, args)

    return _LANES(values), generate


@_instructions
def where_positive(_typing, tested, values):
    """The values of the lanes in which ``tested`` is above 0, and 0 in the others."""

    def generate(_context, builder, _signature, args):
        zero = ir.Constant(_DOUBLES, [0.0] * COUNT)
        return builder.select(builder.fcmp_ordered(">", args[0], zero), args[1], zero)

    return _LANES(tested, values), generate


def _chosen(symbol: str, description: str) -> Callable[..., Any]:
    """Of each lane the value of two that a comparison holds for, the second where it holds for none."""

    def choose(_typing, these, those):
        def generate(_context, builder, _signature, args):
            return builder.select(builder.fcmp_ordered(symbol, *args), *args)

        return _LANES(these, those), generate

    choose.__doc__ = description
    return _instructions(choose)


least = _chosen("<", "The smaller of two values, lane by lane.")
greatest = _chosen(">", "The greater of two values, lane by lane.")


@_instructions
def next_lanes(_typing, these, those):
    """The lanes one further on, ``those`` being the eight after ``these``."""

    def generate(_context, builder, _signature, args):
        return builder.shuffle_vector(*args, ir.Constant(_INDICES, list(range(1, COUNT + 1))))

    return _LANES(these, those), generate


@_instructions
def mask_greater(_typing, values, limits):
    """In which lanes a value is greater than its limit: bit k of an integer for lane k."""

    def generate(_context, builder, _signature, args):
        found = builder.fcmp_ordered(">", *args)
        return builder.zext(builder.bitcast(found, ir.IntType(COUNT)), ir.IntType(64))

    return types.uint64(values, limits), generate


def _append_one_by_one(builder: Any, address: Any, count: Any, begin: Any, byte: Any) -> Any:
    """Write each index where the next one listed shall stand, so that those not wanted are written over."""
    long, listed = ir.IntType(64), ir.IntType(64)(0)
    base = builder.bitcast(address, _INT.as_pointer())
    for lane in range(COUNT):
        index = builder.trunc(builder.add(begin, long(lane)), _INT)
        builder.store(index, builder.gep(base, [listed]), align=4)
        bit = builder.and_(builder.lshr(byte, byte.type(lane)), byte.type(1))
        listed = builder.add(listed, builder.zext(bit, long))
    return builder.add(count, listed)


@_instructions
def append_indices(_typing, found, count, begin, mask):
    """Append ``begin`` + k for every bit k of a mask to the ``count`` numbers listed in ``found`` (uint32), without
    branches; writes eight entries. Returns how many are listed then.
    """

    def generate(context, builder, signature, args):
        array, count, begin, mask = args
        address = _address(context, builder, signature.args[0], array, count, _INDICES)
        first = builder.insert_element(ir.Constant(_INDICES, ir.Undefined), builder.trunc(begin, _INT), _INT(0))
        indices = builder.shuffle_vector(first, first, ir.Constant(_INDICES, [0] * COUNT))
        indices = builder.add(indices, ir.Constant(_INDICES, list(range(COUNT))))
        byte = builder.trunc(mask, ir.IntType(COUNT))
        if not COMPRESSES:
            return _append_one_by_one(builder, address, count, begin, byte)
        compress = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(_INDICES, [_INDICES, _BITS, _INDICES]),
            "llvm.experimental.vector.compress.v8i32",
        )  # fmt: skip
        chosen = builder.call(compress, [indices, builder.bitcast(byte, _BITS), ir.Constant(_INDICES, ir.Undefined)])
        builder.store(chosen, address, align=4)
        return builder.add(count, builder.zext(builder.ctpop(byte), ir.IntType(64)))

    return types.uint64(found, types.uint64, types.uint64, types.uint64), generate
