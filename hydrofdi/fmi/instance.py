"""Instances of FMUs: started with values, stepped with held inputs, and read."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from hydrofdi.compilation.object_code import own_cache
from hydrofdi.errors import ConfigError
from hydrofdi.fmi.description import Model, read_model

_TOLD = 1
"""Least status of a message that is kept: from ``warning`` on."""

_TOLERANCE = 1e-8
"""Largest relative tolerance of the solver of a model exchange."""


class PlantError(Exception):
    """An FMU refuses to go on; the text says what it told."""


@lru_cache(maxsize=4)
def instance_of(path: Path, digest: str) -> Instance:
    """The instance of an FMU in this process.

    Raises
    ------
    ConfigError
        The file is not the one with this SHA-256, or it cannot run here.
    """
    model = read_model(path)
    if model.digest != digest:
        raise ConfigError(f"{path}: has changed since the experiment was read")
    if model.obstacle:
        raise ConfigError(f"{path}: {model.obstacle}")
    return Instance(model)


def _unpacked(model: Model) -> str:
    """Folder with the contents of an FMU; unpacked once for this user."""
    import fmpy

    cache = own_cache("fmus")
    folder = None if cache is None else cache / model.digest
    if folder is not None and folder.is_dir():
        return str(folder)
    part = tempfile.mkdtemp(prefix="hydrofdi-fmu-", dir=cache)
    fmpy.extract(str(model.path), part)
    if folder is None:
        return part
    try:
        os.rename(part, folder)  # whole or not at all
    except OSError:  # another process was first
        shutil.rmtree(part, ignore_errors=True)
    return str(folder)


class Instance:
    """An FMU that is run again and again, each time from its start.

    Each run has an instance of its own; one that can be made only once is reset.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        if multiprocessing.parent_process() is not None:
            os.dup2(2, 1)  # what an FMU prints is no result
        self._folder = _unpacked(model)
        self._is_second = model.source.fmiVersion.startswith("2.")
        self._fmu: Any = None
        self._solver: _Solver | None = None
        self._messages: list[str] = []

    def _heard(self, *told: Any) -> None:
        """Keep what the FMU says of errors; FMI 2 tells its name before the status."""
        status, message = told[2 if self._is_second else 1], told[-1]
        if status >= _TOLD and message:
            text = message.decode(errors="replace") if isinstance(message, bytes) else str(message)
            self._messages = [*self._messages[-3:], " ".join(text.split())]

    def start(self, values: Mapping[str, Any], inputs: Mapping[str, Any], stop_time: float) -> None:
        """Begin a run at t = 0 with start values and first inputs, in the units of the FMU.

        Raises
        ------
        PlantError
            The FMU refuses a value, or finds no initial state.
        """
        self._messages.clear()
        try:
            self._renew()
            self._initialise(values, inputs, stop_time)
        except Exception as error:
            raise self.failed(error) from None

    def _renew(self) -> None:
        from fmpy.simulation import instantiate_fmu

        self._solver, fmu = None, self._fmu
        if fmu is not None and self.model.interface.canBeInstantiatedOnlyOncePerProcess:
            try:
                fmu.reset()
            except Exception:  # not every FMU supports it
                self._free()
        elif fmu is not None and self._is_second:
            # Resets of some FMUs do nothing, or crash; a new instance on the loaded library takes 1 ms.
            fmu.fmi2FreeInstance(fmu.component)
            fmu.instantiate(callbacks=fmu.callbacks)
        elif fmu is not None:
            fmu.fmi3FreeInstance(fmu.component)
            fmu.instantiate(logMessage=self._heard)
        if self._fmu is None:
            self._fmu = instantiate_fmu(self._folder, self.model.source, logger=self._heard)

    def _initialise(self, values: Mapping[str, Any], inputs: Mapping[str, Any], stop_time: float) -> None:
        from fmpy.simulation import apply_start_values, settable_in_instantiated

        fmu, source = self._fmu, self.model.source
        if self._is_second:
            fmu.setupExperiment(startTime=0.0, stopTime=stop_time)
        later = apply_start_values(fmu, source, dict(values), settable=settable_in_instantiated)
        fmu.enterInitializationMode(**({} if self._is_second else {"startTime": 0.0, "stopTime": stop_time}))
        apply_start_values(fmu, source, later | dict(inputs))
        fmu.exitInitializationMode()
        if not self.model.is_co_simulation:
            self._solver = _Solver(self.model, fmu)

    def setter(self, names: Sequence[str]) -> Callable[[Sequence[float]], None]:
        """Function that sets inputs, given their values in the order of the names."""
        references = [self.model.variables[name].reference for name in names]
        write = self._fmu.setReal if self._is_second else self._fmu.setFloat64

        def set_inputs(values: Sequence[float]) -> None:
            write(references, values)
            if self._solver is not None:
                self._solver.has_jumped = True

        return set_inputs

    def getter(self, names: Sequence[str]) -> Callable[[], Sequence[float]]:
        """Function that returns the values of variables, in the order of the names."""
        variables = [self.model.variables[name] for name in names]
        readers = {each.kind: getattr(self._fmu, f"get{each.kind}") for each in variables}
        if len(readers) == 1:
            ((_, read),), references = readers.items(), [each.reference for each in variables]
            return lambda: read(references)
        return lambda: [float(readers[each.kind]([each.reference])[0]) for each in variables]

    @property
    def step(self) -> Callable[[float, float], object]:
        """Function that moves the FMU from a time over a step [s]; inputs are held meanwhile."""
        return self._fmu.doStep if self._solver is None else self._solver.step

    def failed(self, error: Exception) -> PlantError:
        """The failure of a run, after which a new FMU takes over."""
        told = "; ".join(dict.fromkeys(self._messages))
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        self._free()
        return PlantError(f"{reason.rstrip('.')}: {told}" if told else reason)

    def end(self) -> None:
        """End a run."""
        try:
            self._fmu.terminate()
        except Exception:  # its results are complete
            self._free()

    def _free(self) -> None:
        fmu, self._fmu, self._solver = self._fmu, None, None
        if fmu is not None:
            try:
                fmu.freeInstance()
            except Exception:  # what cannot be freed is lost with the process
                return


class _Solver:
    """Model exchange by FMPy's CVODE: integrates from one communication point to the next."""

    def __init__(self, model: Model, fmu: Any) -> None:
        from fmpy.sundials import CVodeSolver

        self._fmu, self._is_second = fmu, model.source.fmiVersion.startswith("2.")
        self._completes = bool(model.source.modelExchange.needsCompletedIntegratorStep)
        self.has_jumped = False
        self._next_event = float("inf")
        self._settle()
        stated = model.source.defaultExperiment
        tolerance = float(stated.tolerance) if stated is not None and stated.tolerance else _TOLERANCE
        self._solver = CVodeSolver(
            nx=model.source.numberOfContinuousStates,
            nz=model.source.numberOfEventIndicators,
            get_x=fmu.getContinuousStates,
            set_x=fmu.setContinuousStates,
            get_dx=fmu.getDerivatives if self._is_second else fmu.getContinuousStateDerivatives,
            get_z=fmu.getEventIndicators,
            get_nominals=fmu.getNominalsOfContinuousStates,
            set_time=fmu.setTime,
            input=self,
            startTime=0.0,
            relativeTolerance=min(tolerance, _TOLERANCE),
            maxNumSteps=100_000,
        )

    def apply(self, time: float) -> None:
        """Apply no inputs: they are held between communication points."""

    def step(self, time: float, size: float) -> None:
        """Integrate over a step [s]; events may lie within."""
        end, rounding = time + size, 1e-9 * size
        if self.has_jumped or self._next_event <= time + rounding:
            self._event(time)
        while end - time > rounding:
            is_event, _, time = self._solver.step(time, min(end, self._next_event))
            self._fmu.setTime(time)
            if self._completes:
                entered, terminates = self._fmu.completedIntegratorStep()
                is_event = is_event or entered
                if terminates:
                    raise PlantError("the FMU ended the simulation")
            if is_event or self._next_event <= time + rounding:
                self._event(time)

    def _event(self, time: float) -> None:
        self.has_jumped = False
        self._fmu.enterEventMode()
        self._settle()
        self._solver.reset(time)

    def _settle(self) -> None:
        """Update the discrete states until they stay, and integrate again."""
        update = self._fmu.newDiscreteStates if self._is_second else self._fmu.updateDiscreteStates
        is_needed = True
        while is_needed:
            is_needed, terminates, _, _, is_defined, event = update()
            self._next_event = float(event) if is_defined else float("inf")
            if terminates:
                raise PlantError("the FMU ended the simulation")
        self._fmu.enterContinuousTimeMode()
