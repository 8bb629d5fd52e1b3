"""Conditions on parameters: a small grammar of its own, never evaluated as code.

::

    condition  = conjunction {"or" conjunction}
    conjunction = negation {"and" negation}
    negation   = "not" negation | comparison
    comparison = sum {("<" | "<=" | ">" | ">=" | "==" | "!=") sum}
    sum        = term {("+" | "-") term}
    term       = factor {("*" | "/") factor}
    factor     = "-" factor | number | 'quantity with a unit' | dotted.name | "(" condition ")"
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import Any

from hydrofdi.units import parse_si

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|(?P<name>[A-Za-z_][\w.]*)"
    r"|(?P<text>'[^']*'|\"[^\"]*\")|(?P<operator><=|>=|==|!=|[-+*/<>()]))"
)
_COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq,
    "!=": operator.ne,
}  # fmt: skip
_SUMS: dict[str, Callable[[float, float], float]] = {"+": operator.add, "-": operator.sub}
_TERMS: dict[str, Callable[[float, float], float]] = {
    "*": operator.mul,
    "/": lambda left, right: left / right if right else math.nan,
}

Values = Mapping[str, Any]
Evaluation = Callable[[Values], Any]


class Condition:
    """A parsed condition.

    Attributes
    ----------
    names : frozenset of str
        Dotted parameters that it looks at.
    compared : tuple of (str, str)
        Parameters that are compared with a quoted quantity, and that quantity.
    """

    def __init__(
        self, evaluate: Evaluation, names: frozenset[str], compared: tuple[tuple[str, str], ...]
    ) -> None:
        self._evaluate = evaluate
        self.names = names
        self.compared = compared

    def holds(self, values: Values) -> bool:
        """Whether it holds for parameter values in SI; comparisons with what is not given are false."""
        return bool(self._evaluate(values))


@lru_cache(maxsize=64)
def parse_condition(text: str) -> Condition:
    """The condition that a text states.

    Raises
    ------
    ValueError
        The text does not follow the grammar; says where.
    """
    return _Parser(text).parse()


class _Parser:
    def __init__(self, text: str) -> None:
        self._text = text
        self._names: set[str] = set()
        self._tokens = self._tokenize()
        self._position = 0

    def parse(self) -> Condition:
        evaluate = self._disjunction()
        if self._peek() is not None:
            raise self._error("unexpected")
        return Condition(evaluate, frozenset(self._names), tuple(self._compared_quantities()))

    def _compared_quantities(self) -> Iterator[tuple[str, str]]:
        for left, symbol, right in zip(self._tokens, self._tokens[1:], self._tokens[2:], strict=False):
            if symbol[1] in _COMPARISONS and {left[0], right[0]} == {"name", "text"}:
                name, text = (left[1], right[1]) if left[0] == "name" else (right[1], left[1])
                yield name, text[1:-1]

    def _tokenize(self) -> list[tuple[str, str]]:
        tokens, position = [], 0
        while self._text[position:].strip():
            match = _TOKEN.match(self._text, position)
            if match is None:
                raise ValueError(f"condition {self._text!r}: cannot read {self._text[position:].strip()!r}")
            tokens.append((str(match.lastgroup), match.group(str(match.lastgroup))))
            position = match.end()
        return tokens

    def _peek(self) -> str | None:
        return self._tokens[self._position][1] if self._position < len(self._tokens) else None

    def _take(self, *wanted: str) -> str | None:
        token = self._peek()
        if token in wanted:
            self._position += 1
            return token
        return None

    def _error(self, what: str) -> ValueError:
        found = self._peek()
        return ValueError(f"condition {self._text!r}: {what} {found!r}" if found is not None
                          else f"condition {self._text!r}: ends too early")  # fmt: skip

    def _disjunction(self) -> Evaluation:
        parts = [self._conjunction()]
        while self._take("or"):
            parts.append(self._conjunction())
        return parts[0] if len(parts) == 1 else lambda values: any(part(values) for part in parts)

    def _conjunction(self) -> Evaluation:
        parts = [self._negation()]
        while self._take("and"):
            parts.append(self._negation())
        return parts[0] if len(parts) == 1 else lambda values: all(part(values) for part in parts)

    def _negation(self) -> Evaluation:
        if self._take("not"):
            inner = self._negation()
            return lambda values: not inner(values)
        return self._comparison()

    def _comparison(self) -> Evaluation:
        first = self._chain(_SUMS, lambda: self._chain(_TERMS, self._factor))
        links: list[tuple[Callable[[Any, Any], bool], Evaluation]] = []
        while symbol := self._take(*_COMPARISONS):
            right = self._chain(_SUMS, lambda: self._chain(_TERMS, self._factor))
            links.append((_COMPARISONS[symbol], right))
        if not links:
            return first

        def compare(values: Values) -> bool:
            left = first(values)
            for holds, part in links:
                right = part(values)
                if not holds(left, right):
                    return False
                left = right
            return True

        return compare

    def _chain(
        self, operators: dict[str, Callable[[float, float], float]], operand: Callable[[], Evaluation]
    ) -> Evaluation:
        result = operand()
        while symbol := self._take(*operators):
            result = _combined(operators[symbol], result, operand())
        return result

    def _factor(self) -> Evaluation:
        if self._take("-"):
            inner = self._factor()
            return lambda values: -inner(values)
        if self._take("("):
            grouped = self._disjunction()
            if not self._take(")"):
                raise self._error("expected ')' before")
            return grouped
        if self._position >= len(self._tokens) or self._peek() in ("and", "or", "not"):
            raise self._error("unexpected")
        kind, text = self._tokens[self._position]
        if kind == "operator":
            raise self._error("unexpected")
        self._position += 1
        return self._operand(kind, text)

    def _operand(self, kind: str, text: str) -> Evaluation:
        if kind == "name":
            self._names.add(text)
            return lambda values: _number(values[text])
        constant: Any = float(text) if kind == "number" else _quoted(text[1:-1])
        return lambda values: constant


def _combined(apply: Callable[[float, float], float], left: Evaluation, right: Evaluation) -> Evaluation:
    return lambda values: apply(left(values), right(values))


def _number(value: Any) -> Any:
    return math.nan if value is None else value


def _quoted(text: str) -> Any:
    try:
        return parse_si(text)
    except ValueError:
        return text
