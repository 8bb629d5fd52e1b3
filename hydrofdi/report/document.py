"""A report before it is written in any form: its sections, and those that every report has."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.drive import without_contents
from hydrofdi.config.request import OWN_PLANT, parameter_names
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
    lead: tuple[str, ...]
    blocks: tuple[Block, ...]

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of all figures."""
        return tuple(name for block in self.blocks for name in block.figures)


@dataclass(frozen=True)
class FigureKind:
    """A figure of a report: its caption, and what draws it with matplotlib."""

    caption: str
    draw: Callable[[], Any]


class ComposedReport(Protocol):
    """A report before it is written in any form, whatever it is about."""

    @property
    def name(self) -> str:
        """The experiment."""

    @property
    def path(self) -> Path:
        """The experiment file."""

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn by default."""

    def document(self) -> Document:
        """Its sections."""

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""

    def columns(self) -> dict[str, list[Any]]:
        """Header → values of CSV."""

    def wide(self) -> dict[str, list[Any]]:
        """Header → values, one per run."""

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure."""

    def checks(self) -> dict[str, bool | None]:
        """Claim that the experiment lists → whether it holds."""


def document_of(title: str, lead: str, blocks: Iterable[Block | None]) -> Document:
    """A report of the sections that there are."""
    return Document(title, (lead,), tuple(block for block in blocks if block is not None))


def answers(*blocks: Block | None) -> tuple[Block | None, ...]:
    """What a terminal shows, and shows last."""
    return tuple(block and replace(block, is_answer=True) for block in blocks)


def remarks_block(data: ExperimentData) -> Block | None:
    """Remarks on all runs: another version of the physics, or another request."""
    return Block("remarks", "Remarks", data.all_remarks) if data.all_remarks else None


def holes_block(data: ExperimentData) -> Block | None:
    """Runs without results by status and reason, with the remedy; None if all runs have results."""
    statuses, messages = (data.columns[name].astype(str).tolist() for name in (STATUS, MESSAGE))
    holes = Counter(each for each in zip(statuses, messages, strict=True) if each[0] != "ok").most_common()
    if not holes:
        return None
    remedies = REMEDIES | {MISSING: "hydrofdi sweep CONFIG computes the missing runs and keeps the others"}
    table = Table.of(
        {
            "Runs": [n_run for _, n_run in holes],
            "Status": [status for (status, _), _ in holes],
            "Reason": [why for (_, why), _ in holes],
            "Remedy": [remedies.get(status, "") for (status, _), _ in holes],
        },
        key="runs-without-results",
    )
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
            rows.append((f"{doubt.word} ({doubt.mark})", int(own.sum()), meaning, doubt.remedy))
    if not rows:
        return ()
    n_run = counted(len(doubts), "run")
    said = f"To be read with care, of {n_run}: {', '.join(f'{n:,} {word}' for word, n, *_ in rows)}."
    columns = dict(zip(("Verdict", "Runs", "Meaning", "Remedy"), zip(*rows, strict=True), strict=True))
    table = Table.of(columns, key="doubts")
    return (
        Block("verdicts", "Verdicts", (said,), is_answer=True),
        Block("doubts", "How reliable the runs are", (), (table,)),
    )


def provenance_block(data: ExperimentData) -> Block:
    """What the experiment states, the library versions, and the settings at their defaults."""
    libraries = sorted(data.versions)
    versions = {"Library": libraries, "Version": [data.versions[name] for name in libraries]}
    stated, others = _settings(data)
    return Block(
        "provenance",
        "Configuration and provenance",
        ("An identical request gives identical runs, whatever the batch or worker count.",),
        (
            _settings_table("configuration", "What the experiment sets", stated),
            Table.of(versions, title="Versions", key="versions"),
            replace(_settings_table("defaults", "Settings at their default values", others), is_folded=True),
        ),
    )


def _settings(data: ExperimentData) -> tuple[dict[str, Any], dict[str, Any]]:
    """The settings that differ from their defaults, and the others; without what is empty.

    The configuration is as it is written in the file: parameters of later versions are not in it. Its values
    have the units that it states, which are left out.
    """
    usual = _flat(ExperimentConfig(name=data.experiment.name).model_dump(mode="json")) | {"name": None}
    configuration = data.configuration or data.experiment.model_dump(mode="json")
    settings: tuple[dict[str, Any], dict[str, Any]] = ({}, {})
    replaced = OWN_PLANT if data.experiment.plant.fmu else ()
    for key, content in _flat(without_contents(configuration)).items():
        is_usual = key in usual and usual[key] == content
        if content not in (None, "", [], {}) and not (is_usual and key.partition(".")[0] in replaced):
            settings[is_usual][key] = content
    return settings


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


def _settings_table(key: str, title: str, settings: dict[str, Any]) -> Table:
    texts = [_text(name.rpartition(": ")[2], content) for name, content in settings.items()]
    return Table.of({"Key": [*settings], "Value": texts}, title=title, key=key)


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
