"""The sensors that a simulated study gives its scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hydrofdi.config import ExperimentConfig
from hydrofdi.config.shown_values import shown_value
from hydrofdi.records import Channel
from hydrofdi.report.detection.selection import best_of_sensors
from hydrofdi.report.document import Cell, Sheet
from hydrofdi.report.wording import joined
from hydrofdi.settings.readable import HOLE
from hydrofdi.studies.judgement import Detection

_SECTIONS = {
    Channel.CHAMBER_1_PRESSURE: "pressure_1_sensor",
    Channel.CHAMBER_2_PRESSURE: "pressure_2_sensor",
    Channel.SUPPLY_PRESSURE: "supply_sensor",
    Channel.PISTON_POSITION: "position_sensor",
    Channel.PISTON_VELOCITY: "velocity_sensor",
    Channel.SPOOL_POSITION: "spool_sensor",
    Channel.INPUT_VOLTAGE: "voltage_sensor",
}


@dataclass(frozen=True)
class Sensor:
    """A sensor as it is simulated: its section, and what it adds to the signal, empty if nothing."""

    channel: Channel
    section: str
    noise: str
    bias: str
    bits: str

    @property
    def symbol(self) -> str:
        """Symbol of its channel."""
        return self.channel.symbol

    @property
    def is_perfect(self) -> bool:
        """Whether a measured signal is shown without noise; the voltage is a command, which is known."""
        return not self.noise and self.channel is not Channel.INPUT_VOLTAGE


def sensors_of(experiment: ExperimentConfig, detection: Detection) -> tuple[Sensor, ...]:
    """The sensors of all scores that are judged."""
    used = {channel for each in detection.judgements for channel in each.scored.channels}
    return tuple(
        _sensor(experiment, detection, channel, section)
        for channel, section in _SECTIONS.items()
        if channel.value in used
    )


def _sensor(experiment: ExperimentConfig, detection: Detection, channel: Channel, section: str) -> Sensor:
    drawn = experiment.study.population.over if experiment.study else {}
    chosen = {**detection.records.design, **drawn}

    def text(field: str) -> str:
        name = f"{section}.{field}"
        value = chosen.get(name, experiment.value(name))
        return shown_value(name, value) if value else ""

    return Sensor(channel, section, text("noise") or text("noise_density"), text("bias"), text("bits"))


def sensors_sheet(sensors: Sequence[Sensor]) -> Sheet:
    """A row for each sensor."""
    rows = tuple(
        (
            Cell(f"{each.channel.symbol} ({each.section})"),
            Cell(each.noise or "none"),
            Cell(each.bias or "none"),
            Cell(each.bits or HOLE),
        )
        for each in sensors
    )
    title, headers = "Sensors that the scores use", ("Sensor", "Noise", "Bias", "Bits")
    return Sheet("sensors", title, headers, rows, text_columns=(0, 1, 2))


def perfect_sensors(sensors: Sequence[Sensor], detection: Detection) -> tuple[Sensor, ...]:
    """Sensors without noise that the best score with some set of sensors uses."""
    used = {channel for each in best_of_sensors(detection) for channel in each.scored.channels}
    return tuple(each for each in sensors if each.is_perfect and each.channel.value in used)


def perfect_sentence(sensors: Sequence[Sensor]) -> str:
    """That an answer holds for perfect sensors; empty if it does not."""
    if not sensors:
        return ""
    symbols, sections = (joined([getattr(each, name) for each in sensors]) for name in ("symbol", "section"))
    return (
        f"{symbols} {'are' if len(sensors) > 1 else 'is'} measured without noise here: scores that use"
        f" {'them' if len(sensors) > 1 else 'it'} hold for perfect sensors. Describe {sections}, or name the"
        " sensors that there are: detection.sensors."
    )
