"""The report of any experiment: what its runs are, how far each feature moves, and the same for programs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from hydrofdi.config.request import parameter_unit
from hydrofdi.config.values import shown_values
from hydrofdi.report import indicators as measured
from hydrofdi.report import responses as responding
from hydrofdi.report import runs
from hydrofdi.report.document import Block, ComposedReport, FigureKind
from hydrofdi.report.views import Plane, View, external_view, healthy_view, matrix_block, plane_of
from hydrofdi.settings.messages import convert, counted
from hydrofdi.store import names
from hydrofdi.store.experiment_data import ExperimentData
from hydrofdi.store.verdicts import DOUBTS, doubts_of
from hydrofdi.tables.table import Column, Table, group_breaks, plain

_DELTAS = {
    names.DETAIL_RMS: "delta",
    names.APPROXIMATION_RMS: "approximation_delta",
    names.SETTLED_DETAIL_RMS: "settled_delta",
    names.SETTLED_APPROXIMATION_RMS: "settled_approximation_delta",
}
"""Variable → how data for programs name its δ."""


@dataclass(frozen=True)
class Report(ComposedReport):
    """The report of an experiment, in parts that forms are made from; a paper's study adds its own."""

    data: ExperimentData

    lead = "Indicators of the runs, and how they change over the varied parameters."

    @cached_property
    def table(self) -> runs.ReportedRuns:
        """Its runs."""
        return runs.run_table(self.data)

    @cached_property
    def indicators(self) -> tuple[measured.MeasuredIndicator, ...]:
        """Indicators beside the details of P_1, if the experiment measures any."""
        return measured.measured_indicators(self.data)

    @cached_property
    def responses(self) -> responding.ResponseStudy:
        """What each feature does over each parameter that varies."""
        return responding.study_responses(self.data, self.indicators)

    @cached_property
    def plane(self) -> Plane | None:
        """The runs over the two parameters that matter most, if they are a grid of them."""
        return plane_of(self.data, self.responses)

    @property
    def has_baseline(self) -> bool:
        """Whether there is a healthy run that the others are compared with."""
        return bool((self.data.fixed_baseline != names.NO_BASELINE).any())

    @cached_property
    def baselines(self) -> tuple[str, ...]:
        """``fixed`` and ``matched``, without a baseline for which δ is zero or the same as for the other."""
        own, fixed, matched = np.arange(self.data.n_run), self.data.fixed_baseline, self.data.matched_baseline
        others = {"fixed": names.NO_BASELINE, "matched": fixed}
        pairs = zip(others.items(), (fixed, matched), strict=True)
        return tuple(name for (name, other), rows in pairs if ((rows != own) & (rows != other)).any())

    @property
    def no_changes(self) -> str:
        """Why there is no δ, or why it would be zero for every run; empty if there is δ."""
        if not self.has_baseline:
            alone = "it is a single run; 'hydrofdi sweep' adds the healthy ones"
            reason = alone if self.data.n_run == 1 else "the baseline itself leaks"
            return f"There is no healthy run to compare with ({reason}): δ is not known."
        if self.baselines:
            return ""
        return (
            "Each run is its own healthy baseline, because no run leaks and the baseline sets none of the"
            " varied parameters: δ is zero by construction. To see δ, set a varied parameter in the baseline."
        )

    @cached_property
    def views(self) -> tuple[View, ...]:
        """Sections, and data for JSON, of what the experiment asks for beyond indicators."""
        if not (self.data.has_details and self.has_results):
            return ()
        return tuple(view for view in (external_view(self.table), healthy_view(self.table)) if view)

    def blocks(self) -> Iterable[Block | None]:
        """Its own sections."""
        changes = None
        if self.data.has_details:
            changes = self.changes_block("Change of the details over the varied parameters", "changes")
            changes = replace(changes, is_answer=not self.responses.axes)
        return (
            self.varied_block(),
            matrix_block(self.plane) if self.plane else None,
            *(block for block, _ in self.views),
            responding.responses_block(self.responses),
            changes,
            measured.indicators_block(self.indicators),
            self.summary_block(),
        )

    def varied_block(self) -> Block:
        """Parameters with their values, or ranges of them; runs; and the baseline in words."""
        axes = self.responses.axes
        sizes = [sorted(int(group.rows.sum()) for group in axis.groups) for axis in axes]
        columns = (
            Column("Parameter", [axis.header for axis in axes], is_text=True),
            Column("Values", [", ".join(each.text for each in axis.groups) for axis in axes], is_text=True),
            Column("Runs of each", [runs.span_text(f"{each[0]:,}", f"{each[-1]:,}") for each in sizes]),
        )
        table = Table(columns, "Parameters by value", "varied-values")
        said = (f"{name.capitalize()} baseline: {self._words_of(name)}." for name in self.baselines)
        return Block("varied", "What was varied", tuple(said), (table,))

    def summary_block(self) -> Block:
        """Counts of runs, and what moves most."""
        n_swept = int(self.responses.runs.sum())
        n_added = len(self.table) - n_swept
        added = f", and {counted(n_added, 'healthy run')} for comparison" if n_added > 0 else ""
        said = (f"{counted(n_swept, 'run')}{added}.", self.no_changes)
        table = responding.strongest_table(self.responses, 3 if self.plane else 6)
        return Block("strongest", "What moves most", tuple(filter(None, said)), (table,), is_answer=True)

    def changes_block(self, title: str, key: str) -> Block:
        """The table of all runs for each baseline; the RMS if no run has another one as its baseline."""
        table = self.table
        if not self.baselines:
            return Block(key, "RMS of the details", (runs.band_sentence(table),), (rms_table(table),))
        legend = "Marked: largest positive δ of the row. δ > 0: the RMS fell."
        if not table.is_sealed.all():
            legend += " Rows marked sealed have no internal leakage."
        return Block(key, title, (legend, runs.band_sentence(table)), self.delta_tables(key))

    def delta_tables(self, key: str, variable: str = names.DETAIL_RMS, title: str = "") -> tuple[Table, ...]:
        """δ of an RMS of all runs, a table against each baseline."""
        breaks = group_breaks(self.table.leakage_requests.tolist())
        return tuple(
            _rows_table(
                self.table,
                runs.delta_columns(self.table.changes(baseline, variable)),
                title=f"{title}δ [%] against the {baseline} baseline ({self._words_of(baseline)})",
                key=f"{key}-{baseline}",
                breaks=breaks if len(breaks) < len(self.table) - 1 else (),
            )
            for baseline in self.baselines
        )

    def _words_of(self, baseline: str) -> str:
        """The conditions of the fixed or the matched baseline."""
        if baseline == "matched":
            return "sealed, the same conditions as the run"
        conditions, varied, state = self.data.experiment.baseline, self.table.label_names, ["sealed"]
        held = {name: conditions[name] for name in varied if name in conditions}
        if self.data.experiment.plant.takes("fluid.bulk_modulus"):
            state.append(f"EBM {runs.modulus_text(runs.normal_bulk_modulus(self.data))}")
        state += [shown_values(held)] if held else []
        return ", ".join(state + ["otherwise the same parameters as the run"] * (len(held) < len(varied)))

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return self.general_record() | responding.responses_record(self.responses)

    def general_record(self, *, with_rows: bool = True) -> dict[str, Any]:
        """Data of every experiment, with or without its rows; missing numbers are None."""
        record: dict[str, Any] = {"experiment": self.name}
        record["rows"] = self._row_records() if with_rows else []
        record["verdicts"] = dict(Counter(self.table.verdicts))
        if not self.has_baseline:
            record["delta_not_known"] = self.no_changes
        if self.indicators:
            record["indicators"] = [measured.indicator_record(indicator) for indicator in self.indicators]
        for _, data in self.views:
            record |= data
        return record

    def _row_records(self) -> list[dict[str, Any]]:
        table = self.table
        columns = {
            **_modes(table),
            **_means(table),
            "internal_leakage_coefficient": table[names.LEAKAGE_COEFFICIENT],
            "mean_external_leakage_L_per_min": [_converted(pair, "L/min") for pair in table.external_flows],
            **_level_columns(table),
        }
        for baseline in table.data.baselines:
            columns[f"largest_positive_{baseline}"] = runs.level_names(
                runs.best_levels(table.changes(baseline))
            )
        columns |= {
            "labels": table.labels,
            "sealed": table.is_sealed,
            "status": table.texts(names.STATUS),
            "message": table.texts(names.MESSAGE),
            "verdict": table.verdicts,
        }
        outputs = [output for study in self.indicators for output in study.outputs]
        if outputs:
            own = {output.variable: output.values[table.positions] for output in outputs}
            columns["indicators"] = [*Table.of(own)]
        return [*Table.of(columns)]

    def columns(self) -> dict[str, list[Any]]:
        """Header with unit → values, one per run and level; None if a number is missing."""
        table, levels = self.table, range(self.table.n_level)
        flows = enumerate(table.external_flows.T, 1)
        columns = {
            **_modes(table),
            **_means(table),
            **{f"mean_external_leakage_{c}_L_per_min": _converted(own, "L/min") for c, own in flows},
            **_parameters(table),
        }
        by_level: dict[str, Any] = {"level": [runs.level_names(levels)] * len(table), **_level_columns(table)}
        for baseline in table.data.baselines:
            is_best = runs.best_levels(table.changes(baseline))[:, None] == np.array(levels)
            by_level[f"largest_positive_{baseline}"] = is_best.astype(int)
        return {
            header: [
                value for row in plain(own) for value in (row if header in by_level else [row] * len(levels))
            ]
            for header, own in (columns | by_level | self._measured_columns()).items()
        }

    def wide(self) -> dict[str, list[Any]]:
        """Header with unit → values, one per run: what varies, and δ of each level, fixed baseline."""
        table = self.table
        deltas = enumerate(table.changes("fixed").T if self.data.has_details else (), 1)
        columns = {
            **_modes(table),
            **_parameters(table),
            **{f"delta_d{level}_percent": own for level, own in deltas},
            **self._measured_columns(),
        }
        return plain(columns)  # type: ignore[no-any-return]

    def _measured_columns(self) -> dict[str, Any]:
        """Outputs of the indicators with their changes, and how each run ended."""
        table, columns = self.table, dict[str, Any]()
        for study in self.indicators:
            columns |= measured.output_columns(study, table.positions)
        return columns | {"status": table.texts(names.STATUS), "verdict": table.verdicts}

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure; none if no run has results."""
        from hydrofdi.report.figures.sweep import draw_responses, draw_sensitivity

        figures = dict[str, FigureKind]()
        if not self.has_results:
            return figures
        if self.plane:
            caption = "Heat maps over the two parameters that matter most"
            figures["sensitivity"] = FigureKind(caption, partial(draw_sensitivity, self.plane))
        if any(axis.responses for axis in self.responses.axes):
            caption = "Each feature over each parameter that varies: medians and ranges of the runs"
            figures["responses"] = FigureKind(caption, partial(draw_responses, self.responses))
        return figures


def rms_table(table: runs.ReportedRuns) -> Table:
    """The RMS of the details of each run."""
    levels = enumerate(table[names.DETAIL_RMS].T, 1)
    columns = [Column(f"d{k} [kPa]", own, text=runs.kilopascal) for k, own in levels]
    return _rows_table(table, columns, title="RMS of the details of the chamber-1 pressure", key="rms")


def _rows_table(table: runs.ReportedRuns, columns: list[Column], **more: Any) -> Table:
    """Columns between what a run is and its verdict."""
    mode = Column("f_h [Hz]", table[names.MODE_FREQUENCY], text=lambda f: runs.hole_or(f, f"{f:.1f}"))
    lead = [*runs.lead_columns(table), mode]
    doubts = [doubts_of(verdict) for verdict in table.verdicts]
    given = {doubt.word for own in doubts for doubt in own}
    marks = Column("Verdict", [" ".join(doubt.mark for doubt in own) for own in doubts], is_text=True)
    words = ", ".join(f"{doubt.mark} {word}" for word, doubt in DOUBTS.items() if word in given)
    notes = (f"Verdict: {words}.",) if words else ()
    return Table((*lead, *columns, marks), notes=notes, n_lead=len(lead), **more)


def _modes(table: runs.ReportedRuns) -> dict[str, Any]:
    """Identity, leakage and EBM of each run."""
    return {
        "run_id": table.texts(names.RUN_ID),
        "leakage_L_per_min": _converted(table.leakage_flows, "L/min"),
        "bulk_modulus_MPa": _converted(table[names.BULK_MODULUS], "MPa"),
    }


def _means(table: runs.ReportedRuns) -> dict[str, Any]:
    """Mean leakage, mean pressure and hydraulic mode of each run."""
    return {
        "mean_internal_leakage_L_per_min": _converted(table[names.MEAN_LEAKAGE_FLOW], "L/min"),
        "mean_chamber_1_pressure_Pa": table[names.MEAN_CHAMBER_1_PRESSURE],
        "hydraulic_mode_Hz": table[names.MODE_FREQUENCY],
        "hydraulic_mode_damping_ratio": table[names.MODE_DAMPING_RATIO],
    }


def _parameters(table: runs.ReportedRuns) -> dict[str, Any]:
    """K_i and the varied parameters of each run in SI, with their units."""
    columns = dict[str, Any]()
    columns["internal_leakage_coefficient_m3.5_per_kg0.5"] = table[names.LEAKAGE_COEFFICIENT]
    for name in table.label_names:
        unit = parameter_unit(name)
        columns[f"{name} [{unit.replace('*', '·')}]" if unit and unit != "1" else name] = table.values(name)
    return columns


def _level_columns(table: runs.ReportedRuns) -> dict[str, Any]:
    """A number for each run and level: RMS, and δ against either baseline."""
    columns = {}
    for name, delta in _DELTAS.items():
        columns[f"{name}_Pa"] = table[name]
        columns |= {f"{delta}_{each}_percent": table.changes(each, name) for each in table.data.baselines}
    return columns


def _converted(values: runs.Array, unit: str) -> list[float]:
    return [convert(value, unit) for value in values.tolist()]
