"""The sweep block: conditions and axes, and the points that follow from them.

A condition, such as ``friction.coulomb > 0 and fluid.bulk_modulus < '900 MPa'``, is Python; only the
constructs that are listed here are computed.
"""

from __future__ import annotations

import ast
import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, reduce
from itertools import pairwise
from math import prod
from types import CodeType
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from hydrofdi.config.request import full_name, meant, parameter_names, parameter_unit
from hydrofdi.config.values import Distribution, drawn
from hydrofdi.errors import ConfigError, Issue
from hydrofdi.settings.messages import counted
from hydrofdi.settings.quantities import Section
from hydrofdi.units import parse_quantity, parse_si

_ALLOWED = (
    ast.BoolOp, ast.UnaryOp, ast.BinOp, ast.Compare, ast.Name, ast.Load, ast.And, ast.Or, ast.Not, ast.USub,
    ast.UAdd, ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq,
)  # fmt: skip


@dataclass(frozen=True)
class ParsedCondition:
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
def parse_condition(text: str) -> ParsedCondition:
    """The condition that a text states."""
    try:
        written = ast.parse(text.strip(), mode="eval").body
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
    return ParsedCondition(code, names, compared)


class _InSi(ast.NodeTransformer):
    """Full names, and quantities in SI; all that is not listed above is refused."""

    def visit_Name(self, node: ast.expr) -> ast.expr:
        return ast.Name(full_name(ast.unparse(node)), ast.Load())

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        return self.visit_Name(node)

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
            match sorted(pair, key=lambda part: isinstance(part, ast.Constant)):
                case named, ast.Constant(value=str(text)):
                    yield full_name(ast.unparse(named)), text


def _place(error: SyntaxError) -> str:
    return (
        f"cannot read {error.text[error.offset - 1 :]!r}" if error.text and error.offset else "ends too early"
    )


_LARGEST_KEY = 2**62


def distinct_rows(
    columns: Sequence[NDArray[np.int32]], n_row: int
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Distinct rows of columns of integers (-1 or greater), in order of first appearance."""
    key, n_key = np.zeros(n_row, dtype=np.int64), 1
    for column in columns:
        size = int(column.max(initial=-1)) + 2
        if size * n_key > _LARGEST_KEY:
            _, key = np.unique(key, return_inverse=True)
            n_key = n_row
        key, n_key = key * size + (column + 1), n_key * size
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order], rank[inverse]


class SampleConfig(Section):
    """Points drawn from distributions."""

    method: Literal["sobol", "lhs", "random"] = "sobol"
    """Scrambled Sobol sequence, Latin hypercube, or independent draws (scipy.stats.qmc, numpy)."""

    count: Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
    """Number of points; a power of two keeps a Sobol sequence balanced."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed; the same seed gives the same points."""

    over: dict[str, Distribution] = Field(min_length=1)
    """Dotted parameter → its distribution: uniform [low, high], loguniform [low, high],
    normal [mean, standard deviation], truncated_normal [mean, standard deviation, low, high] (of the normal
    distribution before truncation), lognormal [median, factor] (the factor is the geometric standard
    deviation, above 1: two thirds of the draws lie from median/factor to median·factor), triangular [low,
    mode, high], integers [low, high] (integers, both ends included), or choice [value, …]. In place of the
    arguments, ``±20 %`` or ``±1 µm`` is a width about the experiment's own value: it sets the ends of uniform
    and triangular, and the standard deviation of normal."""


_VALUE = {"anyOf": [{"type": "number"}, {"type": "string"}, {"type": "boolean"}]}

GENERATORS = {
    **dict.fromkeys(("linspace", "logspace", "geomspace"), ("first", "last", "count")),
    **dict.fromkeys(("arange", "steps"), ("first", "last", "step")),
}
"""Kind of an axis → the roles of its three numbers; ``steps`` is what ``first:last:step`` stands for."""

ENDS = {"from": "first", "start": "first", "to": "last", "stop": "last", "num": "count", "step": "step"}
"""Key of an axis that is a mapping → its role."""

_THREE = {"type": "array", "items": _VALUE, "minItems": 3, "maxItems": 3}
_LISTS = {
    kind: _THREE | {"description": f"[{', '.join(roles)}]"}
    for kind, roles in GENERATORS.items()
    if kind != "steps"
}
_KEYS = {"type": "object", "additionalProperties": False}
_AXIS = {
    "anyOf": [
        {"type": "array", "items": _VALUE, "minItems": 1},
        {"type": "string", "description": "first:last:count, or first:last:step with a unit"},
        _KEYS | {"properties": _LISTS, "minProperties": 1, "maxProperties": 1},
        _KEYS | {"properties": dict.fromkeys(ENDS, _VALUE), "minProperties": 3, "maxProperties": 3},
    ]
}
_AXES = {"type": "object", "additionalProperties": _AXIS}

Axes = Annotated[dict[str, list[Any]], WithJsonSchema(_AXES)]
"""Dotted parameter → its values in SI; generators are expanded when a file is loaded."""


def _sound_condition(text: Any) -> Any:
    """A condition on parameters that there are, compared with quantities of their units."""
    if isinstance(text, str):
        condition, known = parse_condition(text), parameter_names()
        for name in sorted(condition.names.difference(known)):
            raise ValueError(f"no parameter {name!r}{meant(name)}")
        for name, quantity in condition.compared:
            if name in condition.names and (unit := parameter_unit(name)):
                parse_quantity(quantity, unit)
    return text


class SweepConfig(Section):
    """A block of a sweep."""

    grid: Axes = Field(default_factory=dict)
    """All combinations of the values of several parameters; the last one varies fastest."""

    zip: Axes = Field(default_factory=dict)
    """Parameters that vary together; all lists have the same length."""

    sample: SampleConfig | None = None
    """Points drawn from distributions."""

    union: list[SweepConfig] = Field(default_factory=list)
    """Blocks whose points are concatenated."""

    where: Annotated[str, BeforeValidator(_sound_condition)] | None = None
    """Condition that the points of the block must satisfy, such as ``friction.breakaway >=
    friction.coulomb``. Quantities are quoted: ``fluid.bulk_modulus > '600 MPa'``."""

    @model_validator(mode="after")
    def _zipped_lists_have_one_length(self) -> Self:
        lengths = {name: len(values) for name, values in self.zip.items()}
        if len(set(lengths.values())) > 1:
            lengths_shown = ", ".join(f"{name} has {length}" for name, length in lengths.items())
            raise ValueError(f"zip needs lists of the same length: {lengths_shown}")
        return self

    @model_validator(mode="after")
    def _each_parameter_varies_once(self) -> Self:
        seen: set[str] = set()
        for names in self._groups():
            if twice := seen & names:
                raise ValueError(f"{sorted(twice)[0]} varies in two blocks that multiply")
            seen |= names
        return self

    def _groups(self) -> list[set[str]]:
        in_union = {name for block in self.union for name in block.names}
        return [set(self.grid), set(self.zip), set(self.sample.over if self.sample else ()), in_union]

    @property
    def names_throughout(self) -> set[str]:
        """Parameters that vary in every point of the block, so that their nominal values are not used."""
        return set().union(*self._groups()[:-1])

    def axes(self) -> Iterator[tuple[str, list[Any] | Distribution]]:
        """Each parameter that varies, in the order of the file, with its values or its distribution."""
        yield from self.grid.items()
        yield from self.zip.items()
        yield from self.sample.over.items() if self.sample else ()
        for block in self.union:
            yield from block.axes()

    @property
    def names(self) -> list[str]:
        """All parameters that vary in the block, in the order of the file."""
        return list(dict.fromkeys(name for name, _ in self.axes()))

    @property
    def drawn(self) -> set[str]:
        """Parameters that are drawn from a range."""
        return {name for name, stated in self.axes() if isinstance(stated, dict) and "choice" not in stated}


def _unit_cube(sample: SampleConfig) -> NDArray[np.float64]:
    """Points in the unit cube, shape (count, n_axis)."""
    generator, n_axis = np.random.default_rng(sample.seed), len(sample.over)
    if sample.method == "random":
        return generator.random((sample.count, n_axis))
    from scipy.stats import qmc

    sequence = qmc.Sobol if sample.method == "sobol" else qmc.LatinHypercube
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the user may choose any count, not only powers of two
        cube: NDArray[np.float64] = sequence(n_axis, rng=generator).random(sample.count)
    return cube


NOMINAL = -1
"""Index of a point that does not set the parameter."""


@dataclass(frozen=True)
class SweptValues:
    """The values of one parameter [SI], and the index of each point's; ``NOMINAL`` if the point sets none."""

    values: Sequence[Any]
    index: NDArray[np.int32]


@dataclass(frozen=True)
class Points:
    """Points of a sweep: dotted parameter → its column, each of length `n_point`."""

    n_point: int
    columns: dict[str, SweptValues]

    def at(self, positions: NDArray[np.intp]) -> Points:
        """Some of the points."""
        columns = self.columns.items()
        return Points(
            len(positions), {name: SweptValues(each.values, each.index[positions]) for name, each in columns}
        )

    def values(self, point: int) -> dict[str, Any]:
        """The values in SI that a point sets, by parameter."""
        return {
            name: column.values[column.index[point]]
            for name, column in self.columns.items()
            if column.index[point] != NOMINAL
        }


def count_points(block: SweepConfig) -> int:
    """Number of points of a block, before conditions remove any."""
    lengths = [len(values) for values in block.grid.values()]
    lengths += [len(values) for values in list(block.zip.values())[:1]]
    lengths += [block.sample.count] if block.sample else []
    lengths += [sum(count_points(part) for part in block.union)] if block.union else []
    return prod(lengths)


def sweep_points(block: SweepConfig, nominal: Callable[[str], Any], path: str) -> Points:
    """The points of a block, in order."""
    factors = [side_by_side({name: values}) for name, values in block.grid.items()]
    if block.zip:
        factors.append(side_by_side(block.zip))
    if sample := block.sample:
        laws = zip(_unit_cube(sample).T, sample.over.items(), strict=True)
        columns = {name: drawn(name, law, unit, f"{path}.sample.over.{name}") for unit, (name, law) in laws}
        factors.append(side_by_side(columns))
    if block.union:
        parts = [
            sweep_points(part, nominal, f"{path}.union[{position}]")
            for position, part in enumerate(block.union)
        ]
        factors.append(one_after_the_other(parts))
    points = reduce(multiplied, factors, Points(1, {}))
    return points if block.where is None else _fulfilling(block.where, points, nominal, f"{path}.where")


def side_by_side(columns: Mapping[str, Sequence[Any]]) -> Points:
    """The points that take one value after the other of several parameters at once."""
    n_point = len(next(iter(columns.values())))
    index = np.arange(n_point, dtype=np.int32)
    return Points(n_point, {name: SweptValues(values, index) for name, values in columns.items()})


def multiplied(first: Points, second: Points) -> Points:
    """All combinations of two sets of points; the second varies fastest."""
    slow = np.repeat(np.arange(first.n_point), second.n_point)
    fast = np.tile(np.arange(second.n_point), first.n_point)
    return Points(len(slow), first.at(slow).columns | second.at(fast).columns)


def one_after_the_other(parts: Sequence[Points]) -> Points:
    """The points of several blocks; a point does not set the parameters that only other blocks set."""
    columns = {}
    for name in dict.fromkeys(name for part in parts for name in part.columns):
        values: list[Any] = []
        indices = []
        for part in parts:
            column = part.columns.get(name, SweptValues((), np.full(part.n_point, NOMINAL, dtype=np.int32)))
            indices.append(np.where(column.index == NOMINAL, NOMINAL, column.index + np.int32(len(values))))
            values += column.values
        columns[name] = SweptValues(values, np.concatenate(indices, dtype=np.int32))
    return Points(sum(part.n_point for part in parts), columns)


def _fulfilling(text: str, points: Points, nominal: Callable[[str], Any], path: str) -> Points:
    condition = parse_condition(text)
    constants = {name: nominal(name) for name in condition.names}
    named = Points(points.n_point, {k: v for k, v in points.columns.items() if k in condition.names})
    first, inverse = distinct_rows([column.index for column in named.columns.values()], points.n_point)
    try:
        holds = [condition.holds(constants | named.values(point)) for point in first.tolist()]
    except (TypeError, ValueError, OverflowError) as error:
        raise ConfigError([Issue(f"condition {text!r}: {error}", path)]) from None
    return points.at(np.flatnonzero(np.array(holds, dtype=bool)[inverse]))
