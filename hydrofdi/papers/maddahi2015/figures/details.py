"""Figures 3 and 4: the coefficients of one level over time, one panel per EBM."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hydrofdi.errors import ReportError
from hydrofdi.papers.maddahi2015.figures.choice import run_position, shown_bulk_moduli, shown_leakage
from hydrofdi.papers.maddahi2015.study import Study
from hydrofdi.report.figures.style import series
from hydrofdi.report.wording import kilopascal, mode_name
from hydrofdi.store.layout import names
from hydrofdi.transforms.wavelet import detail_coefficients


def draw_details(study: Study, level: int) -> Figure:
    """The coefficients of a level of P_1 with the small leakage over the EBM."""
    grid, wavelet = study.grid, study.data.experiment.wavelet
    if level > wavelet.levels:
        raise ReportError(f"the experiment has no level d{level}")
    leakage, moduli = shown_leakage(study), shown_bulk_moduli(study)
    flow = grid.leakage_flows[leakage - 1] if leakage else 0.0
    figure = Figure(figsize=(7.0, 0.6 + 1.6 * len(moduli)), layout="constrained")
    axes = figure.subplots(len(moduli), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for number, (axis, beta) in enumerate(zip(axes, moduli, strict=True)):
        position = run_position(study, leakage, beta)
        time, pressure = study.data.signal(names.CHAMBER_1_PRESSURE, position)
        instants, details = detail_coefficients(pressure, wavelet, level, time)
        axis.plot(instants, 1e-3 * details, color=series(number, len(moduli))["color"], linewidth=0.7)
        rms = float(study.data.columns[names.DETAIL_RMS][position][level - 1])
        axis.set_title(f"{mode_name(flow, grid.bulk_moduli[beta])}: RMS {kilopascal(rms)} kPa")
        axis.set_ylabel(f"$d_{level}$ of $P_1$ [kPa]")
    axes[-1].xaxis.set_major_locator(MaxNLocator(10, steps=[1, 2, 5, 10]))
    axes[-1].set_xlabel("time [s]")
    axes[-1].set_xlim(time[0], time[-1])
    return figure
