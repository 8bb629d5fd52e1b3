"""Conditions on parameters, such as ``friction.coulomb > 0 and fluid.bulk_modulus < '900 MPa'``.

They are written in Python syntax and parsed by Python, but never executed. Constructs that are not listed
here are refused.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

from hydrofdi.settings.messages import counted
from hydrofdi.units import parse_si

Values = Mapping[str, Any]

_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.And: all, ast.Or: any,
    ast.Not: operator.not_, ast.USub: operator.neg, ast.UAdd: operator.pos,
    ast.Add: operator.add, ast.Sub: operator.sub,
    ast.Mult: lambda left, right: left * float(right),
    ast.Div: lambda left, right: left / right if right else math.nan,
}  # fmt: skip
_ALLOWED = (ast.BoolOp, ast.UnaryOp, ast.BinOp, ast.Compare, ast.Name, ast.Load, *_OPERATORS)


@dataclass(frozen=True)
class Condition:
    """A parsed condition.

    Attributes
    ----------
    tree : ast.expr
        In which names are dotted parameters, and quoted quantities are numbers in SI.
    names : frozenset of str
        Dotted names of the parameters in the condition.
    compared : tuple of (str, str)
        Each parameter that is compared with a quoted quantity, and the quantity.
    """

    tree: ast.expr
    names: frozenset[str]
    compared: tuple[tuple[str, str], ...]

    def holds(self, values: Values) -> bool:
        """Whether the condition holds for parameter values in SI; None counts as NaN.

        Raises
        ------
        TypeError, ValueError, OverflowError
            Text is compared or calculated with like a number, or a number is too large.
        """
        return bool(_value(self.tree, values))


@lru_cache(maxsize=64)
def parse_condition(text: str) -> Condition:
    """The condition that a text states.

    Raises
    ------
    ValueError
        The text is not a comparison of parameters, numbers and quoted quantities.
    """
    try:
        written = _Named().visit(ast.parse(text.strip(), mode="eval").body)
        compared = tuple(_compared(written))
        tree = _InSi().visit(written)
    except SyntaxError as error:
        raise ValueError(f"condition {text!r}: {_place(error)}") from None
    except (RecursionError, MemoryError):
        raise ValueError(f"condition of {counted(len(text), 'character')} is nested too deeply") from None
    except (ValueError, OverflowError) as error:
        raise ValueError(f"condition {text!r}: {error}") from None
    names = frozenset(node.id for node in ast.walk(tree) if isinstance(node, ast.Name))
    return Condition(tree, names, compared)


class _Named(ast.NodeTransformer):
    """Dotted names as names."""

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        owner = self.visit(node.value)
        return ast.Name(f"{owner.id}.{node.attr}", ast.Load()) if isinstance(owner, ast.Name) else node


class _InSi(ast.NodeTransformer):
    """Quantities in SI; all that is not listed above is refused."""

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if isinstance(node.value, str):
            with suppress(ValueError):
                return ast.Constant(parse_si(node.value))
            return node
        if isinstance(node.value, bool) or not isinstance(node.value, int | float):
            raise ValueError(f"unexpected {ast.unparse(node)!r}")
        return ast.Constant(float(node.value))

    def generic_visit(self, node: ast.AST) -> ast.AST:
        if not isinstance(node, _ALLOWED):
            raise ValueError(f"unexpected {ast.unparse(node) or type(node).__name__!r}")
        return super().generic_visit(node)


def _value(node: ast.expr, values: Values) -> Any:
    match node:
        case ast.BoolOp(op=junction, values=parts):
            return _OPERATORS[type(junction)](_value(part, values) for part in parts)
        case ast.UnaryOp(op=sign, operand=inner):
            return _OPERATORS[type(sign)](_value(inner, values))
        case ast.BinOp(op=symbol, left=left, right=right):
            return _OPERATORS[type(symbol)](_value(left, values), _value(right, values))
        case ast.Compare(left=left, ops=symbols, comparators=others):
            pairs = pairwise([_value(part, values) for part in (left, *others)])
            return all(_OPERATORS[type(symbol)](*pair) for symbol, pair in zip(symbols, pairs, strict=True))
        case ast.Name(id=name):
            return math.nan if values[name] is None else values[name]
        case ast.Constant(value=number):
            return number
    raise AssertionError(node)


def _compared(tree: ast.expr) -> Iterator[tuple[str, str]]:
    for node in ast.walk(tree):
        for pair in pairwise([node.left, *node.comparators]) if isinstance(node, ast.Compare) else ():
            match sorted(pair, key=lambda part: not isinstance(part, ast.Name)):
                case ast.Name(id=name), ast.Constant(value=str(text)):
                    yield name, text


def _place(error: SyntaxError) -> str:
    return (
        f"cannot read {error.text[error.offset - 1 :]!r}" if error.text and error.offset else "ends too early"
    )
