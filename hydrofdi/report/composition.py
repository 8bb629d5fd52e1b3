"""The report of any experiment: what its runs are, how far each feature moves, and the same for programs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from hydrofdi.config.request import parameter_unit
from hydrofdi.config.values import shown_values
from hydrofdi.report import runs
from hydrofdi.report.document import (
    Block,
    Document,
    FigureKind,
    answers,
    document_of,
    doubts_blocks,
    holes_block,
    provenance_block,
    remarks_block,
)
from hydrofdi.report.indicators import (
    MeasuredIndicator,
    indicator_record,
    indicators_block,
    measured_indicators,
    output_columns,
)
from hydrofdi.report.responses import (
    MOST_VALUES,
    QUANTILES,
    ResponseStudy,
    responses_block,
    responses_record,
    strongest_table,
    study_responses,
)
from hydrofdi.report.views import Plane, View, asked_views, matrix_block, plane_of
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
class Report:
    """The report of an experiment, in parts that forms are made from; a paper's study adds its own."""

    data: ExperimentData

    lead: ClassVar[str] = "Indicators of the runs, and how they change over the varied parameters."

    @property
    def name(self) -> str:
        """The experiment; its files are named after it."""
        return self.data.experiment.name

    @property
    def path(self) -> Path:
        """The experiment file."""
        return self.data.path

    @cached_property
    def table(self) -> runs.ReportedRuns:
        """Its runs."""
        return runs.run_table(self.data)

    @cached_property
    def indicators(self) -> tuple[MeasuredIndicator, ...]:
        """Indicators beside the details of P_1, if the experiment measures any."""
        return measured_indicators(self.data)

    @cached_property
    def responses(self) -> ResponseStudy:
        """What each feature does over each parameter that varies."""
        return study_responses(self.data, self.indicators)

    @cached_property
    def plane(self) -> Plane | None:
        """The runs over the two parameters that matter most, if they are a grid of them."""
        return plane_of(self.data, self.responses)

    @property
    def has_results(self) -> bool:
        """Whether any run has results."""
        return bool(self.table.is_ok.any())

    @property
    def has_baseline(self) -> bool:
        """Whether there is a healthy run that the others are compared with."""
        return bool((self.data.fixed_baseline != names.NO_BASELINE).any())

    @cached_property
    def baselines(self) -> tuple[str, ...]:
        """``fixed`` and ``matched``, without a baseline for which δ is zero or the same as for the other."""
        own, fixed, matched = np.arange(self.data.n_run), self.data.fixed_baseline, self.data.matched_baseline
        tells = {
            "fixed": (fixed != own) & (fixed != names.NO_BASELINE),
            "matched": (matched != own) & (matched != fixed),
        }
        return tuple(name for name, is_other in tells.items() if is_other.any())

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
        wanted = self.data.has_details and self.has_results
        return tuple(asked_views(self.table)) if wanted else ()

    @property
    def usual_figure(self) -> str:
        """The figure that is drawn by default."""
        return "sensitivity" if self.plane else "responses"

    def document(self) -> Document:
        """The sections of the report; of an experiment without results what is missing, and the remedy."""
        data = self.data
        if self.has_results:
            return document_of(self.name, self.lead, self.blocks())
        blocks = (remarks_block(data), holes_block(data), *answers(self.varied_block()))
        return document_of(self.name, self.lead, (*blocks, provenance_block(data)))

    def blocks(self) -> Iterable[Block | None]:
        """The sections where runs have results."""
        title = "Change of the details over the varied parameters"
        own = (self.changes_block(title, "changes"),) if self.data.has_details else ()
        return (
            remarks_block(self.data),
            self.varied_block(),
            holes_block(self.data),
            *doubts_blocks(self.data),
            matrix_block(self.plane) if self.plane else None,
            *(block for block, _ in self.views),
            responses_block(self.responses),
            *(own if self.responses.axes else answers(*own)),
            indicators_block(self.indicators),
            self.summary_block(),
            provenance_block(self.data),
        )

    def varied_block(self) -> Block:
        """Parameters with their values, or quantiles of them; runs; and the baseline in words."""
        axes = self.responses.axes
        ends = [
            [group.text for group in axis.groups]
            if axis.drawn is None
            else map(axis.text, np.nanquantile(axis.drawn, QUANTILES))
            for axis in axes
        ]
        sizes = [sorted(int(group.rows.sum()) for group in axis.groups) for axis in axes]
        counts = ["–".join(f"{n:,}" for n in dict.fromkeys((each[0], each[-1]))) for each in sizes]
        shares = ", ".join(f"{100 * share:g}" for share in QUANTILES)
        note = f"Of more than {MOST_VALUES} values: the {shares} % quantiles, and the runs of each fifth."
        table = Table(
            (
                Column("Parameter", [axis.header for axis in axes], is_text=True),
                Column("Values", [", ".join(texts) for texts in ends], is_text=True),
                Column("Runs of each", counts),
            ),
            "Parameters by value",
            "varied-values",
            (note,) if any(axis.drawn is not None for axis in axes) else (),
        )
        said = [self.no_changes] if self.no_changes else []
        said += [f"{name.capitalize()} baseline: {self._words_of(name)}." for name in self.baselines]
        return Block("varied", "What was varied", tuple(said), (table,))

    def summary_block(self) -> Block:
        """Counts of runs, and what moves most."""
        n_swept = int(self.responses.runs.sum())
        n_added = len(self.table) - n_swept
        added = f", and {counted(n_added, 'healthy run')} for comparison" if n_added > 0 else ""
        said = (f"{counted(n_swept, 'run')}{added}.", self.no_changes)
        table = strongest_table(self.responses, 3 if self.plane else 6)
        return Block("strongest", "What moves most", tuple(filter(None, said)), (table,), is_answer=True)

    def changes_block(self, title: str, key: str) -> Block:
        """The table of all runs for each baseline; the RMS if no run has another one as its baseline."""
        table = self.table
        if not self.baselines:
            return Block(key, "RMS of the details", (runs.band_sentence(table),), (rms_table(table),))
        legend = "Marked: largest positive δ of the row. δ > 0: the RMS fell."
        if not table.is_sealed.all():
            sealed = "have no internal leakage" if table.varies_external else "are controls"
            legend += f" Rows marked sealed {sealed}."
        return Block(key, title, (legend, runs.band_sentence(table)), self.delta_tables(key))

    def delta_tables(self, key: str, variable: str = names.DETAIL_RMS, title: str = "") -> tuple[Table, ...]:
        """δ of an RMS of all runs, a table against each baseline."""
        breaks = group_breaks(self.table.leakage_requests.tolist())
        return tuple(
            replace(
                _rows_table(self.table, *runs.delta_columns(self.table.changes(baseline, variable))),
                title=f"{title}δ [%] against the {baseline} baseline ({self._words_of(baseline)})",
                key=f"{key}-{baseline}",
                breaks=breaks if len(breaks) < len(self.table) - 1 else (),
            )
            for baseline in self.baselines
        )

    def _words_of(self, baseline: str) -> str:
        """The conditions of the fixed or the matched baseline."""
        conditions, varied = self.data.experiment.baseline, self.table.label_names
        held = {name: conditions[name] for name in varied if name in conditions}
        outside = {name: held.pop(name) for name in list(held) if name.startswith(runs.EXTERNAL)}
        sealed = "sealed internally and externally" if outside and not any(outside.values()) else "sealed"
        if baseline == "matched":
            return f"{sealed}, the same conditions as the run"
        state = [sealed]
        if self.data.experiment.plant.takes("fluid.bulk_modulus"):
            state.append(f"EBM {runs.modulus_text(runs.normal_bulk_modulus(self.data))}")
        state += [shown_values(held)] if held else []
        is_alike = len(held) + len(outside) < len(varied)
        return ", ".join([*state, *(["otherwise the same parameters as the run"] if is_alike else [])])

    def record(self) -> dict[str, Any]:
        """Plain data for JSON."""
        record = self.general_record() | responses_record(self.responses)
        return record | {key: value for _, data in self.views for key, value in data.items()}

    def general_record(self, *, with_rows: bool = True) -> dict[str, Any]:
        """Data of every experiment, with or without its rows; missing numbers are None."""
        record: dict[str, Any] = {"experiment": self.name}
        record["rows"] = self._row_records() if with_rows else []
        record["verdicts"] = dict(Counter(self.table.verdicts))
        if not self.has_baseline:
            record["delta_not_known"] = self.no_changes
        if self.indicators:
            record["indicators"] = [indicator_record(indicator) for indicator in self.indicators]
        return record

    def _row_records(self) -> list[dict[str, Any]]:
        table = self.table
        columns = {
            **_modes(table),
            "internal_leakage_coefficient": table[names.LEAKAGE_COEFFICIENT],
            "mean_internal_leakage_L_per_min": _converted(table[names.MEAN_LEAKAGE_FLOW], "L/min"),
            "mean_external_leakage_L_per_min": [_converted(pair, "L/min") for pair in table.external_flows],
            **_dynamics(table),
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
            measured = {output.variable: output.values[table.positions] for output in outputs}
            columns["indicators"] = [*Table.of(measured)]
        return [*Table.of(columns)]

    def columns(self) -> dict[str, list[Any]]:
        """Header with unit → values, one per run and level; None if a number is missing."""
        table, levels = self.table, range(self.table.n_level)
        flows = enumerate(table.external_flows.T, 1)
        columns = {
            **_modes(table),
            "mean_internal_leakage_L_per_min": _converted(table[names.MEAN_LEAKAGE_FLOW], "L/min"),
            **_dynamics(table),
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
            columns |= output_columns(study, table.positions)
        return columns | {"status": table.texts(names.STATUS), "verdict": table.verdicts}

    def figures(self) -> Mapping[str, FigureKind]:
        """Name → figure; none if no run has results."""
        from hydrofdi.report.figures.sweep import draw_responses, draw_sensitivity

        figures = {}
        if self.has_results and self.plane:
            caption = "Heat maps over the two parameters that matter most"
            figures["sensitivity"] = FigureKind(caption, partial(draw_sensitivity, self.plane))
        if self.has_results and any(axis.responses for axis in self.responses.axes):
            caption = (
                "Each feature over each parameter that varies: median and range of the runs with each value"
            )
            figures["responses"] = FigureKind(caption, partial(draw_responses, self.responses))
        return figures

    def checks(self) -> dict[str, bool | None]:
        """Nothing: only a paper's study has claims."""
        return {}


def rms_table(table: runs.ReportedRuns) -> Table:
    """The RMS of the details of each run."""
    levels = enumerate(table[names.DETAIL_RMS].T, 1)
    columns = (Column(f"d{k} [kPa]", own, text=runs.kilopascal) for k, own in levels)
    return replace(
        _rows_table(table, *columns), title="RMS of the details of the chamber-1 pressure", key="rms"
    )


def _rows_table(table: runs.ReportedRuns, *columns: Column) -> Table:
    """Columns between what a run is and its verdict."""
    mode = Column("f_h [Hz]", table[names.MODE_FREQUENCY], text=lambda f: runs.hole_or(f, f"{f:.1f}"))
    lead = [*runs.lead_columns(table), mode]
    doubts = [doubts_of(verdict) for verdict in table.verdicts]
    given = {doubt.word for own in doubts for doubt in own}
    if not given:
        return Table((*lead, *columns), n_lead=len(lead))
    marks = Column("Verdict", [" ".join(doubt.mark for doubt in own) for own in doubts], is_text=True)
    words = ", ".join(f"{doubt.mark} {word}" for word, doubt in DOUBTS.items() if word in given)
    return Table((*lead, *columns, marks), notes=(f"Verdict: {words}.",), n_lead=len(lead))


def _modes(table: runs.ReportedRuns) -> dict[str, Any]:
    """Identity, leakage and EBM of each run."""
    return {
        "run_id": table.texts(names.RUN_ID),
        "leakage_L_per_min": _converted(table.leakage_flows, "L/min"),
        "bulk_modulus_MPa": _converted(table[names.BULK_MODULUS], "MPa"),
    }


def _dynamics(table: runs.ReportedRuns) -> dict[str, Any]:
    """Mean pressure and hydraulic mode of each run."""
    return {
        "mean_chamber_1_pressure_Pa": table[names.MEAN_CHAMBER_1_PRESSURE],
        "hydraulic_mode_Hz": table[names.MODE_FREQUENCY],
        "hydraulic_mode_damping_ratio": table[names.MODE_DAMPING_RATIO],
    }


def _parameters(table: runs.ReportedRuns) -> dict[str, Any]:
    """K_i and the varied parameters of each run in SI, with their units."""
    headers = {}
    for name in table.label_names:
        unit = parameter_unit(name)
        headers[name] = f"{name} [{unit.replace('*', '·')}]" if unit and unit != "1" else name
    coefficients = {"internal_leakage_coefficient_m3.5_per_kg0.5": table[names.LEAKAGE_COEFFICIENT]}
    return coefficients | {header: table.values(name) for name, header in headers.items()}


def _level_columns(table: runs.ReportedRuns) -> dict[str, Any]:
    """A number for each run and level: RMS, and δ against either baseline."""
    columns = {}
    for name, delta in _DELTAS.items():
        columns[f"{name}_Pa"] = table[name]
        columns |= {f"{delta}_{each}_percent": table.changes(each, name) for each in table.data.baselines}
    return columns


def _converted(values: runs.Array, unit: str) -> list[float]:
    return [convert(value, unit) for value in values.tolist()]
