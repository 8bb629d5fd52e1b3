"""Stored results of sweeps."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, overload

import numpy as np
from numpy.typing import NDArray

from hydrofdi.config import expand_runs
from hydrofdi.config.experiment import INTERNAL_LEAKAGE_FORMS
from hydrofdi.config.runs import Runs
from hydrofdi.config.values import shown_in
from hydrofdi.errors import ReportError, StoreError
from hydrofdi.settings.arguments import path_of
from hydrofdi.settings.messages import counted
from hydrofdi.store.names import LEVEL, MESSAGE, RUN, SIGNALS, STATUS, SWEPT, TIME, VERDICT, coordinate
from hydrofdi.store.verdicts import doubt_counts
from hydrofdi.tables.table import Table, library

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from hydrofdi.api.run import Run
    from hydrofdi.execution.sweeping import SweepSummary
    from hydrofdi.records import Channel, RecordSource
    from hydrofdi.report.document import ComposedReport
    from hydrofdi.store.experiment_data import ExperimentData


_LEAST_FULL = 4
"""Cells for each run, beyond which points are no grid."""


class Markdown(str):
    """A text that consoles print and notebooks render."""

    __repr__ = _repr_markdown_ = str.__str__


class Results:
    """What an experiment has stored; `hydrofdi.sweep` and `hydrofdi.load` make it.

    Attributes
    ----------
    summary : SweepSummary or None
        What the sweep did that made them; None if they were stored before.
    """

    def __init__(self, data: ExperimentData | Path, summary: SweepSummary | None = None) -> None:
        self._data, self.summary = data, summary

    @cached_property
    def data(self) -> ExperimentData:
        """Runs and their numbers, signals left on disk."""
        from hydrofdi.store.results import read_results

        return read_results(self._data) if isinstance(self._data, Path) else self._data

    @property
    def file(self) -> Path:
        """The experiment file."""
        return self.data.path

    @property
    def folder(self) -> Path:
        """Its folder."""
        return self.data.path.parent

    def __len__(self) -> int:
        """Number of runs."""
        return self.data.n_run

    @cached_property
    def _specs(self) -> Runs:
        return expand_runs(self.data.experiment).runs

    @overload
    def __getitem__(self, run: int) -> Run: ...
    @overload
    def __getitem__(self, run: slice) -> list[Run]: ...
    def __getitem__(self, run: int | slice) -> Run | list[Run]:
        """A run with its features and stored signals, by its position; several for a slice."""
        from hydrofdi.api.run import Run

        if isinstance(run, slice):
            return [self[each] for each in range(len(self))[run]]
        at = range(len(self))[run]
        columns = {name: values[at : at + 1] for name, values in self.data.columns.items()}
        if (time := self.data.signals.time()) is not None:
            columns |= self.data.signals.rows(SIGNALS, [at]) | {TIME: time}
        return Run(self.data.experiment, self._specs[at], columns)

    def signals(self, run: int) -> dict[str, NDArray[np.float64]]:
        """Name or symbol → samples of a run, shape (n_time,), in SI; empty if none are stored."""
        return self[run].signals

    @cached_property
    def runs(self) -> Table:
        """All runs: position, what varies [SI], status, verdict and message."""
        requests = dict.fromkeys(INTERNAL_LEAKAGE_FORMS, self.data.leakage_requests.tolist())
        names = self.data.experiment.varied_names
        varied = {name: requests.get(name) or self.data.values(name) for name in names}
        texts = {name: [*map(str, self.data.columns[name])] for name in (STATUS, VERDICT, MESSAGE)}
        return Table.of({RUN: [*range(len(self))], **varied, **texts}, row=RUN)

    @property
    def failed(self) -> Table:
        """Those of the `runs` that did not end well."""
        return self.runs.at([row for row, status in enumerate(self.runs[STATUS]) if status != "ok"])

    @property
    def statuses(self) -> dict[str, int]:
        """How runs ended → how many: ``ok``, ``missing``, or a failure; see `verdicts` too."""
        return dict(Counter(map(str, self.data.columns[STATUS])))

    @property
    def verdicts(self) -> dict[str, int]:
        """Words of the verdicts on runs that ended well → number of runs, ``ok`` left out."""
        return doubt_counts(map(str, self.data.columns[VERDICT]))

    @cached_property
    def warnings(self) -> list[str]:
        """Warnings of the sweep, one sentence each, as `hydrofdi.plan` has them."""
        if self.summary is not None:
            return [*self.summary.warnings]
        from hydrofdi.execution.plan import plan_sweep

        with shown_in(self.data.experiment.units):
            return plan_sweep(self.data.experiment, self.folder).warnings

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """All runs with the dimensions run, time and level; numbers are read when they are used.

        Runs of a study have the coordinates ``population``, such as ``healthy`` or ``0.1 L/min``,
        ``population_kind``, such as ``fault``, and ``is_fit``, whether thresholds are set on the run.

        Raises
        ------
        ReportError
            The extra ``notebook`` is not installed, or the file does not contain the runs of its study.
        StoreError
            The sweep has not ended, so that there is no file yet.
        """
        loaded = library("xarray")
        library("h5netcdf")
        if not self.file.exists():
            raise StoreError(f"{self.folder}: the sweep is not finished; 'hydrofdi collect' builds the file")
        dataset: xarray.Dataset = loaded.open_dataset(self.file, engine="h5netcdf")
        if self.data.experiment.study is None:
            return dataset
        from hydrofdi.studies.reading import stored_roles

        roles = stored_roles(self.data)
        populations = [roles.populations[place] for place in roles.of_run]
        coordinates = {
            "population": [each.name for each in populations],
            "population_kind": [str(each.kind) for each in populations],
            "is_fit": [each.is_fit for each in populations],
        }
        return dataset.assign_coords({name: (RUN, values) for name, values in coordinates.items()})

    def to_xarray(self) -> xarray.Dataset:
        """The `dataset`, as other results have it."""
        return self.dataset

    def grid(self) -> xarray.Dataset:
        """Features with a dimension for each parameter that varies, such as ``EBM`` and ``K_i``.

        ``delta``: δ of the details against the fixed baseline [%]. Runs that were added for comparison are
        left out, and signals, which the `dataset` has.

        Raises
        ------
        ReportError
            The points are no grid: at most a cell in four has a run; or as for `dataset`.
        """
        from hydrofdi.report.runs import baseline_changes

        axes = [*map(coordinate, self.data.experiment.varied_names)]
        if axes and SWEPT.name not in self.dataset and self.data.experiment.study is None:
            raise ReportError(f"{self.file}: is of an earlier version; 'hydrofdi collect' adds coordinates")
        axes = [name for name in axes if name in self.dataset]
        sizes = [len({*self.dataset[name].values.tolist()}) for name in axes]
        if not axes or math.prod(sizes) > _LEAST_FULL * len(self):
            raise ReportError("the points of the sweep are no grid; see .dataset")
        delta = {"units": "%", "long_name": "fall of the RMS of a detail against the fixed baseline"}
        changes = (RUN, LEVEL), baseline_changes(self.data)["fixed"], delta
        features = self.dataset.drop_dims(TIME, errors="ignore").assign(delta=changes)
        points = features.isel(run=features.swept).drop_vars([RUN, SWEPT.name])
        cube: xarray.Dataset
        if len(axes) == 1:
            cube = points.swap_dims({RUN: axes[0]}).sortby(axes[0])
        else:
            cube = points.set_index(run=axes).unstack(RUN)
        return cube.transpose(*axes, ...)

    @cached_property
    def table(self) -> Table:
        """The numbers that ``hydrofdi report --format csv`` prints; units stand in the names."""
        return Table.of(self.composed.columns())

    def to_pandas(self) -> pandas.DataFrame:
        """The `table` as a data frame; pandas must be installed."""
        return self.table.to_pandas()

    def record_source(self, channels: Collection[Channel]) -> RecordSource:
        """The stored runs as records, so that `hydrofdi.measure` and others take results as they are."""
        from hydrofdi.store.experiment_data import StoredRecords

        return StoredRecords(self.data, str(self.folder), channels)

    def to_latex(self) -> str:
        """The answers of the report as tables for LaTeX, as ``hydrofdi report --format latex`` has them."""
        from hydrofdi.report.page import render_latex

        with shown_in(self.data.experiment.units):
            return render_latex(self.composed.document())

    def report(self) -> Markdown:
        """The report as Markdown, as ``hydrofdi report --format markdown`` prints it."""
        from hydrofdi.report.page import render_markdown

        with shown_in(self.data.experiment.units):
            return Markdown(render_markdown(self.composed.document()))

    def plot(self, figure: str | None = None) -> Figure:
        """A figure of the report by its name; the usual one where it is left out.

        Raises
        ------
        ReportError
            There is no such figure.
        """
        from hydrofdi.report.figures import draw_figure

        with shown_in(self.data.experiment.units):
            return draw_figure(self.composed, figure)

    @cached_property
    def composed(self) -> ComposedReport:
        """The report before it is written in any form."""
        from hydrofdi.papers import make_report

        return make_report(self.data)

    def __repr__(self) -> str:
        verdicts = self.verdicts
        done = "done" if verdicts else "ok"
        ends = {done if word == "ok" else word: n for word, n in self.statuses.items()} | verdicts
        warned = () if self.summary is None else self.summary.warnings
        told = f"; {counted(len(warned), 'warning')}, see .warnings" if warned else ""
        shown = ", ".join(f"{count:,} {word}" for word, count in ends.items())
        return f"{counted(self.data.n_run, 'run')} in {self.folder}: {shown}{told}"


def load(folder: str | PathLike[str] | None = None) -> Results:
    """Stored results, finished or not.

    Parameters
    ----------
    folder : path, optional
        Folder of an experiment, or its file. By default the newest below ``results/``.

    Raises
    ------
    ReportError, StoreError
        There are none; the file is missing, damaged, or of another version.
    """
    from hydrofdi.store.results import read_results

    return Results(read_results(None if folder is None else path_of(folder)))


def report(folder: str | PathLike[str] | Results | None = None) -> Markdown:
    """The report on stored results, as ``hydrofdi report --format markdown`` prints it.

    Parameters
    ----------
    folder : path or Results, optional
        As for `hydrofdi.load`, as are errors.
    """
    return (folder if isinstance(folder, Results) else load(folder)).report()
