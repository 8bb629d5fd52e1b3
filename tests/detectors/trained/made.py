"""Detectors by hand, and windows that they judge."""

import numpy as np

from hydrofdi.detectors.configuration import DetectorConfig, TimedChart, feature_of
from hydrofdi.detectors.detector import Detector
from hydrofdi.detectors.file import ChartLimit, DetectorFile, detector_text
from hydrofdi.detectors.verdicts import channel_facts, learned_range
from hydrofdi.records import Channel
from hydrofdi.records.streams import Window
from tests.records.measuring import csv_of

FREQUENCY = 1000.0


def signals(seed, n_sample=1000):
    """All channels of an actuator in some motion, with noise of its own."""
    draw = np.random.default_rng(seed)
    time = np.arange(n_sample) / FREQUENCY
    drive = np.sign(np.sin(2.0 * np.pi * 2.0 * time + 0.1))
    swing = np.convolve(drive, np.exp(-np.arange(200) / 40.0) / 40.0)[:n_sample]
    noise = draw.standard_normal((8, n_sample))
    position = 0.05 * np.cumsum(swing) / FREQUENCY
    return {
        Channel.CHAMBER_1_PRESSURE: 9e6 + 2e6 * swing + 2e4 * noise[0],
        Channel.CHAMBER_2_PRESSURE: 8e6 - 2e6 * swing + 2e4 * noise[1],
        Channel.SUPPLY_PRESSURE: 17e6 + 1e4 * noise[2],
        Channel.RETURN_PRESSURE: 1e5 + 1e3 * noise[3],
        Channel.PISTON_POSITION: 0.3 + position + 1e-5 * noise[4],
        Channel.PISTON_VELOCITY: 0.05 * swing + 1e-3 * noise[5],
        Channel.SPOOL_POSITION: 1e-4 * drive + 1e-7 * noise[6],
        Channel.INPUT_VOLTAGE: 5.0 * drive,
    }


def window(number=0, seed=0, n_sample=1000, fault=None, **changed):
    """A window of such signals; `changed` replaces channels, or leaves those out that are None."""
    channels = signals(seed, n_sample) | {Channel(name): samples for name, samples in changed.items()}
    kept = {channel: samples for channel, samples in channels.items() if samples is not None}
    return Window(number, np.arange(n_sample) / FREQUENCY, kept, fault)


def detector(indicator="dwt", limits=(None, np.inf), scale=(0.0, 1.0), scores=None, ranges=(), **more):
    """A detector that nobody trained; `ranges` are learned from these windows."""
    config = DetectorConfig.model_validate({"indicator": indicator, **more})
    feature = feature_of(config)
    config = config.model_copy(update={"output": config.output or feature.described.name})
    samples = {each: [window.channels[each] for window in ranges] for each in feature.indicator.channels}
    learned = {
        each: learned_range(each, [channel_facts(np.stack(own))]) for each, own in samples.items() if own
    }
    low, high = limits
    return DetectorFile.model_validate(
        {
            "schema": "hydrofdi.detector",
            "made": {"hydrofdi": "0", "time": "2026-01-01T00:00:00Z"},
            "config": config,
            "indicator_versions": {feature.indicator.name: feature.indicator.version},
            "unit": feature.described.unit,
            "channels": tuple(sorted(feature.indicator.channels)),
            "sampling_frequency": FREQUENCY,
            "n_sample": 1000,
            "basis": {
                "sources": ["made"], "n_record": 99, "n_window": 99, "n_group": 0, "populations": {},
                "not_judged": {},
            },
            "healthy": {"centre": scale[0], "spread": scale[1], "range": scores},
            "limits": {
                "low": low, "high": 1e300 if high == np.inf else high, "false_alarm_rate": 0.01,
                "interval": (0.0, 0.05), "confidence": 0.95, "method": "quantile",
                "interval_rests_on": "windows",
            },
            "ranges": learned,
        }
    )  # fmt: skip


def with_limit(factor, has_ranges=False, **config):
    """A detector of the noise of P1, with a limit above the scores of healthy windows by this factor."""
    healthy = [window(number, 100 + number) for number in range(20)]
    learned = healthy if has_ranges else ()
    scores = [verdict.score for verdict in Detector(detector(ranges=learned, **config)).score(healthy)]
    scale = (float(np.median(scores)), float(np.std(scores)))
    return detector(limits=(None, factor * max(scores)), scale=scale, ranges=learned, **config)


def with_chart(file, chart="cusum", limit=8.0, **options):
    """The same with a chart of this limit."""
    known = ChartLimit(limit=limit, mean_time=None, interval=(0.0, None), hours=1.0)
    config = file.config.model_copy(update={"chart": TimedChart(chart=chart, options=options)})
    return file.model_copy(update={"chart": known, "config": config})


def noise_detector(folder, **config):
    path = folder / "detector.json"
    path.write_text(detector_text(with_limit(1.2, has_ranges=True, **config)), encoding="utf-8")
    return path


def pressure(n_window=5, seed=1, leaking=()):
    """P1 of so many seconds; in some of them the noise is threefold."""
    samples = signals(seed, n_window * 1000)[Channel.CHAMBER_1_PRESSURE]
    noise = np.random.default_rng(seed + 1).standard_normal(samples.size) * 3e4
    for number in leaking:
        part = slice(number * 1000, (number + 1) * 1000)
        samples[part] += noise[part]
    return samples


def written(path, samples, frequency=FREQUENCY, name="P1 [Pa]"):
    time = np.arange(samples.size) / frequency
    path.write_text(csv_of(("time [s]", time), (name, samples)), encoding="utf-8")
    return path
