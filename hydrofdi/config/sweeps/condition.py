"""Conditions on parameters, such as ``friction.coulomb > 0 and fluid.bulk_modulus < '900 MPa'``.

They are written in Python syntax and parsed by Python, but never executed. Constructs that are not listed
here are refused.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from itertools import pairwise
from typing import Any

from hydrofdi.settings.counting import counted
from hydrofdi.units import parse_si

Values = Mapping[str, Any]
Evaluation = Callable[[Values], Any]

_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
    ast.Eq: operator.eq, ast.NotEq: operator.ne,
}  # fmt: skip
_ARITHMETIC: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: lambda left, right: left * float(right),
    ast.Div: lambda left, right: left / right if right else math.nan,
}
_SIGNS: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.Not: operator.not_, ast.USub: operator.neg, ast.UAdd: operator.pos,
}  # fmt: skip
_JUNCTIONS: dict[type[ast.boolop], Callable[[Iterator[Any]], bool]] = {ast.And: all, ast.Or: any}


class Condition:
    """A parsed condition.

    Attributes
    ----------
    names : frozenset of str
        Dotted names of the parameters in the condition.
    compared : tuple of (str, str)
        Each parameter that is compared with a quoted quantity, and the quantity.
    """

    def __init__(
        self, evaluate: Evaluation, names: frozenset[str], compared: tuple[tuple[str, str], ...]
    ) -> None:
        self._evaluate = evaluate
        self.names = names
        self.compared = compared

    def holds(self, values: Values) -> bool:
        """Whether the condition holds for parameter values in SI; None counts as NaN.

        Raises
        ------
        TypeError, ValueError, OverflowError
            Text is compared or calculated with like a number, or a number is too large.
        """
        return bool(self._evaluate(values))


@lru_cache(maxsize=64)
def parse_condition(text: str) -> Condition:
    """The condition that a text states.

    Raises
    ------
    ValueError
        The text is not a comparison of parameters, numbers and quoted quantities.
    """
    try:
        tree = ast.parse(text.strip(), mode="eval").body
        evaluate = _evaluation(tree)
    except SyntaxError as error:
        raise ValueError(f"condition {text!r}: {_place(error)}") from None
    except (RecursionError, MemoryError):
        raise ValueError(f"condition of {counted(len(text), 'character')} is nested too deeply") from None
    except (ValueError, OverflowError) as error:
        raise ValueError(f"condition {text!r}: {error}") from None
    return Condition(evaluate, frozenset(_names(tree)), tuple(_compared(tree)))


def _evaluation(node: ast.expr) -> Evaluation:
    name = _dotted_name(node)
    match node:
        case ast.BoolOp(op=junction, values=parts):
            return _junction(_JUNCTIONS[type(junction)], [_evaluation(part) for part in parts])
        case ast.UnaryOp(op=sign, operand=inner) if type(sign) in _SIGNS:
            return _applied(_SIGNS[type(sign)], _evaluation(inner))
        case ast.BinOp(op=symbol, left=left, right=right) if type(symbol) in _ARITHMETIC:
            return _applied(_ARITHMETIC[type(symbol)], _evaluation(left), _evaluation(right))
        case ast.Compare(left=left, ops=symbols, comparators=others) if _are_known(symbols):
            return _comparison(symbols, [_evaluation(part) for part in (left, *others)])
        case ast.Constant(value=str(quantity)):
            return _constant(_quoted(quantity))
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return _constant(float(number))
        case _ if name:
            return lambda values: math.nan if values[name] is None else values[name]
    raise ValueError(f"unexpected {ast.unparse(node)!r}")


def _are_known(symbols: list[ast.cmpop]) -> bool:
    return all(type(symbol) in _COMPARISONS for symbol in symbols)


def _junction(decide: Callable[[Iterator[Any]], bool], parts: list[Evaluation]) -> Evaluation:
    return lambda values: decide(part(values) for part in parts)


def _applied(apply: Callable[..., Any], *operands: Evaluation) -> Evaluation:
    return lambda values: apply(*(operand(values) for operand in operands))


def _comparison(symbols: list[ast.cmpop], parts: list[Evaluation]) -> Evaluation:
    tests = [_COMPARISONS[type(symbol)] for symbol in symbols]

    def holds(values: Values) -> bool:
        numbers = [part(values) for part in parts]
        return all(test(*pair) for test, *pair in zip(tests, numbers, numbers[1:], strict=False))

    return holds


def _constant(value: Any) -> Evaluation:
    return lambda values: value


def _quoted(text: str) -> Any:
    try:
        return parse_si(text)
    except ValueError:
        return text


def _dotted_name(node: ast.AST) -> str:
    """``section.field`` as it was written; empty if the node is not a name."""
    match node:
        case ast.Name(id=name):
            return name
        case ast.Attribute(value=ast.Name() | ast.Attribute() as owner, attr=field):
            return f"{outer}.{field}" if (outer := _dotted_name(owner)) else ""
    return ""


def _names(node: ast.AST) -> Iterator[str]:
    if name := _dotted_name(node):
        yield name
        return
    for part in ast.iter_child_nodes(node):
        yield from _names(part)


def _compared(tree: ast.expr) -> Iterator[tuple[str, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            parts = [node.left, *node.comparators]
            for pair in pairwise(parts):
                for one, other in (pair, pair[::-1]):
                    match other:
                        case ast.Constant(value=str(text)) if name := _dotted_name(one):
                            yield name, text


def _place(error: SyntaxError) -> str:
    return (
        f"cannot read {error.text[error.offset - 1 :]!r}" if error.text and error.offset else "ends too early"
    )
