"""Figures of single runs and records are drawn."""

import hydrofdi
from hydrofdi.records import Channel, RecordBatch
from hydrofdi.report.figures.signals import draw_record
from hydrofdi.report.figures.style import figure_bytes


def test_the_signals_of_a_run_can_be_read():
    for settings in ({}, {"law": "pi"}):
        run = hydrofdi.simulate({"record": {"duration": "4 s"}, "control": settings})
        assert figure_bytes(run.plot(), "png")


def test_a_record_can_be_read():
    dataset = hydrofdi.simulate(duration="4 s").to_xarray()
    names = ("chamber_1_pressure", "chamber_2_pressure", "piston_position", "input_voltage")
    channels = {Channel(name): dataset[name].values[None, :] for name in names}
    record = RecordBatch(channels, 500.0, ("made",))
    assert figure_bytes(draw_record(record), "png")
