"""Conditions on parameters, such as ``friction.coulomb > 0 and fluid.bulk_modulus < '900 MPa'``.

Only the constructs of Python that are listed here are computed.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from types import CodeType
from typing import Any

from hydrofdi.config.names import full_name
from hydrofdi.settings.messages import counted
from hydrofdi.units import parse_si

_ALLOWED = (
    ast.BoolOp, ast.UnaryOp, ast.BinOp, ast.Compare, ast.Name, ast.Load, ast.And, ast.Or, ast.Not, ast.USub,
    ast.UAdd, ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq,
)  # fmt: skip


@dataclass(frozen=True)
class Condition:
    """A parsed condition: its code, the parameters in it, and those compared with quoted quantities."""

    code: CodeType
    names: frozenset[str]
    compared: tuple[tuple[str, str], ...]

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Whether the condition holds for parameter values in SI; None counts as NaN."""
        # a whole number times a text would repeat it, without limit
        real = {name: float(value) if isinstance(value, int) else value for name, value in values.items()}
        known = {name: math.nan if value is None else value for name, value in real.items()}
        return bool(eval(self.code, {"__builtins__": {}}, known))


@lru_cache(maxsize=64)
def parse_condition(text: str) -> Condition:
    """The condition that a text states."""
    try:
        written = _Named().visit(ast.parse(text.strip(), mode="eval").body)
        compared = tuple(_compared(written))
        tree = _InSi().visit(written)
        code = compile(ast.fix_missing_locations(ast.Expression(tree)), "<condition>", "eval")
    except SyntaxError as error:
        raise ValueError(f"condition {text!r}: {_place(error)}") from None
    except (RecursionError, MemoryError):
        raise ValueError(f"condition of {counted(len(text), 'character')} is nested too deeply") from None
    except (ValueError, OverflowError) as error:
        raise ValueError(f"condition {text!r}: {error}") from None
    names = frozenset(node.id for node in ast.walk(tree) if isinstance(node, ast.Name))
    return Condition(code, names, compared)


class _Named(ast.NodeTransformer):
    """Names, symbols and dotted names as full names."""

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.Name(full_name(node.id), ast.Load())

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        owner = self.visit(node.value)
        if isinstance(owner, ast.Name):
            return ast.Name(full_name(f"{owner.id}.{node.attr}"), ast.Load())
        return node


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

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.Div):  # what is divided by zero is NaN
            node.right = ast.BoolOp(ast.Or(), [node.right, ast.Constant(math.nan)])
        return node

    def generic_visit(self, node: ast.AST) -> ast.AST:
        if not isinstance(node, _ALLOWED):
            raise ValueError(f"unexpected {ast.unparse(node) or type(node).__name__!r}")
        return super().generic_visit(node)


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
