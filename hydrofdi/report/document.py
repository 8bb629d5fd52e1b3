"""A report before it is written in any form: its sections, and those that every report has."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.drive import without_contents
from hydrofdi.config.request import parameter_names
from hydrofdi.config.values import shown_value
from hydrofdi.settings.messages import counted
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.names import MESSAGE, MISSING, STATUS, VERDICT
from hydrofdi.store.verdicts import DOUBTS, REMEDIES, doubts_of
from hydrofdi.tables.table import Table


@dataclass(frozen=True)
class Block:
    """A section of a report: a heading, what the numbers say, tables, and names of figures.

    Answers are what a terminal shows of a report, and shows last.
    """

    key: str
    title: str
    paragraphs: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    figures: tuple[str, ...] = ()
    is_answer: bool = False

    @property
    def shown_tables(self) -> tuple[Table, ...]:
        """The tables that have rows."""
        return tuple(table for table in self.tables if len(table))


@dataclass(frozen=True)
class Document:
    """A report."""

    title: str
    lead: str
    blocks: tuple[Block, ...]

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of all figures."""
        return tuple(name for block in self.blocks for name in block.figures)


class FigureKind(NamedTuple):
    """A figure of a report: its caption, and what draws it with matplotlib."""

    caption: str
    draw: Callable[[], Any]


class ComposedReport(ABC):
    """A report before it is written in any form, of an experiment or of measured records."""

    data: ExperimentData | None
    lead: ClassVar[str]

    @property
    def name(self) -> str:
        """The experiment; its files are named after it."""
        return self.data.experiment.name if self.data else "evaluation"

    @property
    def path(self) -> Path:
        """The experiment file."""
        return self.data.path if self.data else Path()

    @property
    def has_results(self) -> bool:
        """Whether any run has results; otherwise the report says only what is missing."""
        return self.data is None or "ok" in self.data.columns[STATUS].astype(str)

    def document(self) -> Document:
        """Its sections, between those that the report of any experiment has."""
        own = self.blocks() if self.has_results else ()
        if self.data is not None:
            general = remarks_block(self.data), holes_block(self.data), *doubts_blocks(self.data)
            own = (*general, *own, provenance_block(self.data))
        return Document(self.name, self.lead, tuple(block for block in own if block is not None))

    @abstractmethod
    def blocks(self) -> Iterable[Block | None]:
        """Its own sections."""

    @abstractmethod
    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""

    @abstractmethod
    def columns(self) -> dict[str, list[Any]]:
        """Header → values of CSV."""

    def wide(self) -> dict[str, list[Any]]:
        """Header → values, one per run; the same where there are no levels."""
        return self.columns()

    @abstractmethod
    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure, the usual one first; none without results."""

    def checks(self) -> dict[str, bool | None]:
        """Claim that the experiment lists → whether it holds; only a paper's study has claims."""
        return {}


def remarks_block(data: ExperimentData) -> Block | None:
    """Remarks on all runs: another version of the physics, or another request."""
    return Block("remarks", "Remarks", data.all_remarks, is_answer=True) if data.all_remarks else None


def holes_block(data: ExperimentData) -> Block | None:
    """Runs without results by status and reason, with the remedy; None if all runs have results."""
    statuses, messages = (data.columns[name].astype(str).tolist() for name in (STATUS, MESSAGE))
    holes = Counter(each for each in zip(statuses, messages, strict=True) if each[0] != "ok").most_common()
    if not holes:
        return None
    remedies = REMEDIES | {MISSING: "hydrofdi sweep CONFIG computes the missing runs and keeps the others"}
    rows = [
        {"runs": n_run, "status": status, "reason": why, "remedy": remedies.get(status, "")}
        for (status, why), n_run in holes
    ]
    table = Table.of_records(rows, key="runs-without-results")
    lead = f"{sum(n_run for _, n_run in holes):,} of {counted(len(statuses), 'run')} without results."
    return Block("holes", "What is missing", (lead,), (table,), is_answer=True)


def doubts_blocks(data: ExperimentData) -> tuple[Block, ...]:
    """How many runs have which verdict; then what it means, by the worst number, and the remedy."""
    doubts = [doubts_of(verdict) for verdict in data.columns.get(VERDICT, np.empty(0)).astype(str)]
    rows = []
    for doubt in DOUBTS.values():
        own = np.array([doubt in each for each in doubts])
        if own.any():
            worst = 100.0 * float(np.nanmax(data.columns[doubt.number][own]))
            meaning = doubt.meaning.format(f"{worst:.2g}" if worst < 99.5 else f"{worst:.0f}")
            named = {"verdict": f"{doubt.word} ({doubt.mark})", "runs": int(own.sum())}
            rows.append(named | {"meaning": meaning, "remedy": doubt.remedy})
    if not rows:
        return ()
    counts = ", ".join(f"{row['runs']:,} {row['verdict']}" for row in rows)
    said = f"To be read with care, of {counted(len(doubts), 'run')}: {counts}."
    table = Table.of_records(rows, key="doubts")
    answer = Block("verdicts", "Verdicts", (said,), is_answer=True)
    return answer, Block("doubts", "How reliable the runs are", (), (table,))


def provenance_block(data: ExperimentData) -> Block:
    """What the experiment sets beside the defaults of its version, and the library versions.

    The configuration is as it is written in the file: parameters of later versions are not in it. Its values
    have the units that it states, which are left out.
    """
    libraries = sorted(data.versions)
    versions = {"Library": libraries, "Version": [data.versions[name] for name in libraries]}
    usual = _flat(ExperimentConfig(name=data.experiment.name).model_dump(mode="json")) | {"name": None}
    configuration = _flat(without_contents(data.configuration or data.experiment.model_dump(mode="json")))
    stated = {
        key: _text(key.rpartition(": ")[2], content)
        for key, content in configuration.items()
        if content not in (None, "", [], {}, usual.get(key))
    }
    settings = {"Key": [*stated], "Value": [*stated.values()]}
    return Block(
        "provenance",
        "Configuration and provenance",
        ("An identical request gives identical runs, whatever the batch or worker count.",),
        (
            Table.of(settings, title="What the experiment sets", key="configuration"),
            Table.of(versions, title="Versions", key="versions"),
        ),
    )


def _flat(configuration: dict[str, Any]) -> dict[str, Any]:
    """Section and field → what the field contains."""
    flat = {}
    for section, value in configuration.items():
        if section == "indicators" and isinstance(value, dict):
            value = {label: options or "default options" for label, options in value.items()}
        if not isinstance(value, dict):
            flat[section] = value
        elif section != "units":
            for name, content in value.items():
                is_changed = "." in name and section != "plant"  # a parameter within a section, not of an FMU
                flat[f"{section}{': ' if is_changed else '.'}{name}"] = content
    return flat


def _text(name: str, content: Any) -> str:
    """A value with its unit where it is that of a parameter; mappings and lists part by part."""
    if name in parameter_names():
        values = content if isinstance(content, list) else [content]
        return ", ".join(shown_value(name, value) for value in values)
    if isinstance(content, dict):
        parts = {key: value for key, value in content.items() if value is not None}
        return "; ".join(f"{key}: {_text(key, value)}" for key, value in parts.items())
    if isinstance(content, list):
        return ", ".join(_text(name, value) for value in content)
    return content if isinstance(content, str) else json.dumps(content)
