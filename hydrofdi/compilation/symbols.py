"""Machine code of functions that run once with symbols in place of numbers, which record their operations.

What depends on no symbol (options, names, loops over fields) is plain Python, so machine code contains only
what its options require, and no types are inferred. Loops and conditions that depend on symbols are written
with `each` and `when`. LLVM optimises the result.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from hydrofdi.physics import FAST_MATH

ir: Any
_REAL: Any
_INTEGER: Any
_TRUTH: Any
_POINTER: Any
_FLAGS = tuple(sorted(FAST_MATH))
_REAL_OPERATIONS = {"add": "fadd", "subtract": "fsub", "multiply": "fmul", "divide": "fdiv"}
_INTRINSICS = {
    "sqrt": "llvm.sqrt", "floor": "llvm.floor", "copysign": "llvm.copysign", "rint": "llvm.rint",
    "absolute": "llvm.fabs",
}  # fmt: skip
# Division and remainder truncate: operands are not negative.
_INTEGER_OPERATIONS = {
    "add": "add", "subtract": "sub", "multiply": "mul", "floor_divide": "sdiv", "remainder": "srem",
    "left_shift": "shl", "right_shift": "ashr", "bitwise_and": "and_",
}  # fmt: skip
_COMPARISONS = {"less": "<", "less_equal": "<=", "greater": ">", "greater_equal": ">=", "equal": "=="}

_builders: list[Any] = []
"""Where instructions are appended, while a function is recorded."""
_recording = Lock()


def _load_compiler() -> None:
    """Import llvmlite when the first function is recorded: most commands record none."""
    global ir, _REAL, _INTEGER, _TRUTH, _POINTER
    from llvmlite import ir

    _REAL, _INTEGER, _TRUTH, _POINTER = ir.DoubleType(), ir.IntType(64), ir.IntType(1), ir.PointerType()


class Symbol(NDArrayOperatorsMixin):
    """A number that is known when the machine code runs: real, an integer or a truth value."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __bool__(self) -> bool:
        raise TypeError("a symbol has no truth value: use np.where, np.minimum, np.maximum, each or when")

    def view(self, dtype: Any) -> Symbol:
        """The same 64 bits as another type."""
        return Symbol(_builders[-1].bitcast(self.value, _REAL if dtype is np.float64 else _INTEGER))

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *operands: Any, out: Any = None) -> Symbol:
        return Symbol(_instruction(ufunc.__name__, operands))

    def __array_function__(self, function: Any, types: Any, operands: Any, options: Any) -> Any:
        if function is not np.where:
            return NotImplemented
        condition, *choices = operands
        return Symbol(_builders[-1].select(condition.value, *_unified(choices)))


def _unified(operands: tuple[Any, ...] | list[Any]) -> list[Any]:
    """Values of one type, real if any is."""
    values = [each.value if isinstance(each, Symbol) else each for each in operands]
    real = any(isinstance(each, float) or getattr(each, "type", None) == _REAL for each in values)
    return [_converted(each, real) for each in values]


def _converted(value: Any, real: bool) -> Any:
    if not isinstance(value, ir.Value):
        return ir.Constant(_REAL, float(value)) if real else ir.Constant(_INTEGER, int(value))
    if not real or value.type == _REAL:
        return value
    convert = _builders[-1].uitofp if value.type == _TRUTH else _builders[-1].sitofp
    return convert(value, _REAL)


def _instruction(name: str, operands: tuple[Any, ...]) -> Any:
    builder, values = _builders[-1], _unified(operands)
    if values[0].type != _REAL:
        if name in _COMPARISONS:
            return builder.icmp_signed(_COMPARISONS[name], *values)
        return getattr(builder, _INTEGER_OPERATIONS[name])(*values)
    if name in _REAL_OPERATIONS:
        return getattr(builder, _REAL_OPERATIONS[name])(*values, flags=_FLAGS)
    if name in _COMPARISONS:
        return builder.fcmp_ordered(_COMPARISONS[name], *values, flags=_FLAGS)
    if name == "negative":
        return builder.fsub(ir.Constant(_REAL, -0.0), *values, flags=_FLAGS)
    if name in ("minimum", "maximum"):
        # One instruction of vector units; the first operand remains if it is NaN.
        before = builder.fcmp_ordered("<" if name == "minimum" else ">", values[1], values[0], flags=_FLAGS)
        return builder.select(before, values[1], values[0])
    called = ir.FunctionType(_REAL, [_REAL] * len(values))
    intrinsic = builder.module.declare_intrinsic(_INTRINSICS[name], [_REAL], called)
    return builder.call(intrinsic, values, fastmath=_FLAGS)


class Memory:
    """An array, or a record or its field, in memory; its sizes and strides [bytes] may be symbols."""

    def __init__(self, pointer: Any, dtype: Any, shape: tuple[Any, ...], strides: tuple[Any, ...]) -> None:
        self._pointer, self._dtype, self.shape, self._strides = pointer, dtype, shape, strides

    def __getattr__(self, name: str) -> Memory:
        field, offset = self._dtype.fields[name][:2]
        return Memory(_moved(self._pointer, offset), field.base, field.shape, (field.base.itemsize,))

    def __getitem__(self, index: Any) -> Any:
        part = self._part(index)
        if part.shape or self._dtype.names:
            return part
        return Symbol(_builders[-1].load(part._pointer, typ=self._type, align=8))

    def __setitem__(self, index: Any, value: Any) -> None:
        (converted,) = (_converted(each, self._type == _REAL) for each in _unified([value]))
        _builders[-1].store(converted, self._part(index)._pointer, align=8)

    @property
    def _type(self) -> Any:
        return {"f8": _REAL, "i8": _INTEGER}[self._dtype.str[1:]]

    def _part(self, index: Any) -> Memory:
        pointer, indices = self._pointer, index if isinstance(index, tuple) else (index,)
        for number, stride in zip(indices, self._strides, strict=False):
            if isinstance(number, int) and number < 0:
                raise IndexError("an index from the end needs the size of a symbol")
            pointer = _moved(pointer, number * stride)
        return Memory(pointer, self._dtype, self.shape[len(indices) :], self._strides[len(indices) :])


def _moved(pointer: Any, offset: Any) -> Any:
    return _builders[-1].gep(pointer, _unified([offset]), inbounds=True, source_etype=ir.IntType(8))


def local(size: int) -> Memory:
    """Numbers that keep their values between the rounds of a loop; zero at first."""
    builder = _builders[-1]
    with builder.goto_entry_block():
        pointer = builder.alloca(_REAL, size)
    memory = Memory(pointer, np.dtype(np.float64), (size,), (8,))
    for k in range(size):
        memory[k] = 0.0
    return memory


def each(count: Any) -> Iterator[Any]:
    """Indices of a loop over 0 … count − 1: one symbol while machine code is recorded, else integers."""
    if not _builders:
        yield from range(count)
        return
    builder = _builders[-1]
    before = builder.block
    head, body, after = (builder.append_basic_block(name) for name in ("loop", "body", "after"))
    builder.branch(head)
    builder.position_at_end(head)
    index = builder.phi(_INTEGER)
    index.add_incoming(ir.Constant(_INTEGER, 0), before)
    builder.cbranch(builder.icmp_signed("<", index, *_unified([count])), body, after)
    builder.position_at_end(body)
    yield Symbol(index)
    index.add_incoming(builder.add(index, ir.Constant(_INTEGER, 1), flags=("nsw", "nuw")), builder.block)
    builder.branch(head)
    builder.position_at_end(after)


@contextmanager
def when(condition: Any) -> Iterator[None]:
    """Instructions that run only if a condition holds."""
    with _builders[-1].if_then(condition.value):
        yield


@contextmanager
def when_else(condition: Any) -> Iterator[tuple[Any, Any]]:
    """Two blocks of instructions: one if a condition holds, one if not."""
    with _builders[-1].if_else(condition.value) as blocks:
        yield blocks


def recorded(function: Callable[..., None], arguments: tuple[Any, ...], name: str) -> str:
    """LLVM assembly of a function for arguments of these types and, if not arrays or numbers, these values.

    Its machine code is called like that of numba: two pointers that it does not use, then an array as owner,
    parent, number of elements, their size, data, shape and strides.
    """
    _load_compiler()
    types = [_POINTER, _POINTER]
    for argument in arguments:
        if isinstance(argument, np.ndarray):
            sizes = [_INTEGER] * argument.ndim
            types += [_POINTER, _POINTER, _INTEGER, _INTEGER, _POINTER, *sizes, *sizes]
        elif is_dynamic(argument):
            types.append(_REAL if isinstance(argument, float) else _INTEGER)
    module = ir.Module()
    entry = ir.Function(module, ir.FunctionType(ir.IntType(32), types), name)
    builder = ir.IRBuilder(entry.append_basic_block())
    with _recording:
        _builders.append(builder)
        try:
            function(*_symbols(arguments, iter(entry.args[2:])))
        finally:
            _builders.pop()
    builder.ret(ir.Constant(ir.IntType(32), 0))
    return str(module)


def _symbols(arguments: tuple[Any, ...], given: Iterator[Any]) -> Iterator[Any]:
    for argument in arguments:
        if isinstance(argument, np.ndarray):
            *_, data = (next(given) for _ in range(5))
            data.add_attribute("noalias")
            sizes: list[Any] = [Symbol(next(given)) for _ in range(2 * argument.ndim)]
            shape, strides = sizes[: argument.ndim], sizes[argument.ndim :]
            if argument.flags.c_contiguous:
                strides = [argument.itemsize]
                for size in shape[:0:-1]:
                    strides.insert(0, strides[0] * size)
            yield Memory(data, argument.dtype, tuple(shape), tuple(strides))
        else:
            yield Symbol(next(given)) if is_dynamic(argument) else argument


def is_dynamic(argument: Any) -> bool:
    """Whether machine code takes an argument; all others are constants of it."""
    return isinstance(argument, (np.ndarray, float, int, np.integer)) and not isinstance(argument, bool)
