"""Experiment files, their strict models, and the runs that they expand to."""

from hydrofdi.config.experiment import ExperimentConfig
from hydrofdi.config.loading import load_experiment
from hydrofdi.config.request import RunParameters
from hydrofdi.config.runs import RunSpec, RunTable, expand_runs

__all__ = ["ExperimentConfig", "RunParameters", "RunSpec", "RunTable", "expand_runs", "load_experiment"]
