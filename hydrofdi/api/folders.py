"""Questions about the folder of a sweep: progress, integrity, reasons of a run."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral
from os import PathLike

from hydrofdi.api.arguments import refusal
from hydrofdi.api.experiments import Experiment, experiment_of
from hydrofdi.api.places import path_of
from hydrofdi.api.results import Results, results
from hydrofdi.pipeline.inspecting import Explanation, SweepStatus, explain, recompute, sweep_status
from hydrofdi.pipeline.inspecting import verify as find_faults

Folder = str | PathLike[str] | Results
"""Folder of an experiment, or what is stored in it."""


@dataclass(frozen=True)
class Verification:
    """Integrity of a folder, as `hydrofdi.verify` returns it. True if there are no faults.

    Attributes
    ----------
    faults : list of str
        Faults, one sentence each.
    """

    faults: list[str]

    def __bool__(self) -> bool:
        return not self.faults

    def __repr__(self) -> str:
        return "; ".join(self.faults) or "every shard is sound"


@dataclass(frozen=True)
class Rerun:
    """A stored run that was computed again, as `hydrofdi.rerun` returns it. True if all bits agree.

    Attributes
    ----------
    run_id : str
    differing : list of str
        Variables that differ.
    """

    run_id: str
    differing: list[str]

    def __bool__(self) -> bool:
        return not self.differing

    def __repr__(self) -> str:
        return f"run {self.run_id}: " + (
            f"differs in {', '.join(self.differing)}" if self.differing else "the same bits"
        )


def status(folder: Folder) -> SweepStatus:
    """Progress of the latest sweep in a folder.

    Raises
    ------
    StoreError
        The folder contains no experiment.

    Examples
    --------
    >>> import hydrofdi
    >>> stiffness = {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}
    >>> study = {"name": "oils", "record": {"duration": "2 s"}, "sweep": {"grid": stiffness}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> hydrofdi.status(results.folder)
    2 planned, 2 done, 0 failed, 0 missing (2 ok)
    """
    return sweep_status(path_of(folder))


def verify(folder: Folder) -> Verification:
    """Check the checksum of every shard, and whether index and experiment file match.

    Raises
    ------
    StoreError
        The folder contains no experiment.

    Examples
    --------
    >>> import hydrofdi
    >>> study = {"name": "asked", "record": {"duration": "2 s"}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> hydrofdi.verify(results.folder)
    every shard is sound
    """
    return Verification(find_faults(path_of(folder)))


def why(folder: Folder, run: str | int, experiment: Experiment | None = None) -> Explanation:
    """A run explained: its settings, verdict, failure, and what changed since it was stored.

    Parameters
    ----------
    folder : path or Results
    run : str or int
        Beginning of its identity, or its row.
    experiment : path, mapping or ExperimentConfig, optional
        The experiment to compare with; by default the latest request of the folder.

    Raises
    ------
    StoreError
        The folder contains no experiment, or no such run.

    Examples
    --------
    >>> import hydrofdi
    >>> stiffness = {"fluid.bulk_modulus": ["551 MPa", "689 MPa"]}
    >>> study = {"name": "oils", "record": {"duration": "2 s"}, "sweep": {"grid": stiffness}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> hydrofdi.why(results.folder, 1).differences
    {'fluid.bulk_modulus': (551000000.0, 689000000.0)}
    """
    asked = None if experiment is None else experiment_of(experiment, {})
    return explain(path_of(folder), _run(run), asked)


def rerun(folder: Folder, run: str | int) -> Rerun:
    """Compute a stored run again, and compare the bits.

    Raises
    ------
    StoreError
        The folder contains no experiment or no such run, or the run is not stored.

    Examples
    --------
    >>> import hydrofdi
    >>> study = {"name": "asked", "record": {"duration": "2 s"}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> hydrofdi.rerun(results.folder, 0).differing
    []
    """
    return Rerun(*recompute(path_of(folder), _run(run)))


def _run(run: str | int) -> str:
    """A run by its row or identity, as a text."""
    if isinstance(run, bool) or not isinstance(run, str | Integral):
        raise refusal("run", "its row, or the beginning of its identity", run)
    return str(run)


def collect(folder: Folder) -> Results:
    """Build the experiment file from what is stored; runs without a result are holes with a reason.

    Raises
    ------
    StoreError
        The folder contains no experiment, a sweep is at work there, or the file cannot be written.

    Examples
    --------
    >>> import hydrofdi
    >>> study = {"name": "asked", "record": {"duration": "2 s"}}
    >>> results = hydrofdi.sweep(study, engine="in-process")
    >>> hydrofdi.collect(results.folder)
    1 run in results/asked: 1 ok
    """
    from hydrofdi.pipeline.sweeping import collect as build_file

    build_file(path_of(folder))
    return results(path_of(folder))
