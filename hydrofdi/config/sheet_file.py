"""The commented experiment file of a cylinder, from the numbers of its data sheet."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Mapping
from typing import Any

from hydrofdi.config.data_sheet import DEAD_SHARE, HOSE_MODULUS, CylinderSheet
from hydrofdi.config.loading import load_experiment
from hydrofdi.physics.fluid import KELVIN
from hydrofdi.records.data_sheet import StatedMachine, data_sheet_lines
from hydrofdi.settings.files import Source, parse_yaml, ready_folder, scalar, validated
from hydrofdi.settings.files import plain as plain_data
from hydrofdi.settings.messages import plain
from hydrofdi.units import convert

_COMMENT = re.compile(r"^([^#\n]*[^#\s]) {2,}(# .*)$", re.MULTILINE)


_PLACE = re.compile(r"\$\{(?:([\d.e-]+) )?([a-z]\w*) (\S+?)(?: (\d))?\}|\$(\w+)")
"""A place in the layout: ``${0.02 push N 3}`` is a share of a number of the sheet, in a unit and with so many
digits, or in a format such as ``.3g``; ``$name`` is a text.
"""


def name_text(name: str) -> str:
    """A name that YAML reads as text."""
    return name if isinstance(scalar(name), str) else f"'{name}'"


def sheet_text(name: str, given: Mapping[str, Any]) -> str:
    """The file of a cylinder with this data sheet."""
    sheet = validated(CylinderSheet, Source(plain_data(dict(given))))
    layout = (ready_folder() / "templates" / "data-sheet.txt").read_text(encoding="utf-8")
    texts = _texts(name, given, sheet)

    def filled(place: re.Match[str]) -> str:
        factor, quantity, form, n_digit, text = place.groups()
        if text:
            return texts[text]
        value = float(factor or 1.0) * getattr(sheet, quantity)
        return format(value, form) if form.startswith(".") else _shown(value, form, int(n_digit or 4))

    return _COMMENT.sub(_aligned, _PLACE.sub(filled, layout))


def section_text(text: str) -> str:
    """The section ``actuator`` of a description, from the file of a data sheet."""
    made = load_experiment(parse_yaml(text, "").data)
    stated = made.data_sheet | made.indicators["flow_balance"]
    values = {name: stated[name] for name in StatedMachine.model_fields if name in stated}
    return "\n".join(data_sheet_lines(values)) + "\n"


def _aligned(line: re.Match[str]) -> str:
    """A line whose comment begins in column 41 or 65, if there is room."""
    before, comment = line.groups()
    width = next((each for each in (40, 64) if len(before) < each), len(before) + 2)
    return f"{before:{width}}{comment}"


def _command(name: str, given: Mapping[str, Any]) -> str:
    """The command that writes the file, in lines of a comment."""
    lines = [f"hydrofdi init {name}"]
    for key, value in given.items():
        option = f"--{key.replace('_', '-')}" + ("" if value is True else f" {shlex.quote(str(value))}")
        if len(lines[-1]) + len(option) > 100:
            lines.append(f"   {option}")
        else:
            lines[-1] += f" {option}"
    return " \\\n#   ".join(lines)


def _shown(value: float, unit: str, n_digit: int = 4) -> str:
    return f"{plain(convert(value, unit), n_digit)} {unit}"


def _texts(name: str, given: Mapping[str, Any], sheet: CylinderSheet) -> dict[str, str]:
    """Place in the layout → text, or lines."""
    (area_1, area_2), oil, warm = sheet.areas, sheet.fluid, sheet.temperature
    bore, rod, stroke = (_shown(each, "mm") for each in (sheet.bore, sheet.rod, sheet.stroke))
    speed_out, speed_in = sheet.speeds
    return {
        "title": f"{name}: {'double' if sheet.double_rod else 'single'}-rod cylinder"
        f" {bore.removesuffix(' mm')}/{rod.removesuffix(' mm')} × {stroke} at {_shown(sheet.supply, 'bar')}",
        "command": _command(name, given),
        "name": name_text(name),
        "actuator": "\n".join(_areas_and_volumes(sheet, bore, rod)),
        "volumes_vary": "\n".join(
            f"      actuator.{key}: {{uniform: ±7 %}}  # guess: ports and manifold are not on the data sheet"
            for key in ("chamber_volume", "chamber_volume_2")[: 1 if sheet.double_rod else 2]
        ),
        "inclination": f"{ {'vertical-rod-up': 90, 'vertical-rod-down': -90}.get(sheet.mounting, 0)} deg",
        "oil": oil.name,
        "temperature": f"{warm - KELVIN:.4g} °C",
        "viscosity": _shown(oil.kinematic_viscosity(warm), "mm²/s"),
        "oil_table": "\n".join(_oil_table(sheet)),
        "modulus_formula": "measured"
        if sheet.measured_modulus is not None
        else "that of the oil; no hoses"
        if not sheet.hose
        else f"1/({1.0 - sheet.hose_share:.3f}/{_shown(sheet.oil_modulus, 'MPa')} +"
        f" {sheet.hose_share:.3f}/{_shown(HOSE_MODULUS, 'MPa')}); guess: oil and wall of a hose",
        "null_known": "data sheet" if sheet.null_leakage is not None else "guess 1 % of the rated flow",
        "return_guess": "" if "return_pressure" in given else "; guess: filter and cooler",
        "return_comment": "" if "return_pressure" in given else "  # guess",
        "viscous": f"{plain(0.05 * sheet.push / speed_out, 3)} N·s/m",
        "speed_out": _shown(speed_out, "m/s", 3),
        "speed_in": _shown(speed_in, "m/s", 3),
        "integral_gain": plain(0.1 * sheet.crossover * sheet.proportional_gain, 3),
        "less_weight": f", less the weight of {_shown(sheet.weight, 'kN')}" if sheet.weight else "",
        "load_formula": _load_formula(sheet),
        "balance_error": _shown(math.sqrt(2.0) * area_1 * 5e-5 * sheet.stroke, "mm³", 2),
        "supply_known": "sum" if area_1 == area_2 else "nominal",
    }  # fmt: skip


def _areas_and_volumes(sheet: CylinderSheet, bore: str, rod: str) -> list[str]:
    """Lines of the section ``actuator``."""
    annulus, hose = f"π/4 · (({bore})² − ({rod})²)", f" + hose {sheet.hose}" if sheet.hose else ""
    first = annulus if sheet.double_rod else f"π/4 · ({bore})²"
    lines = []
    for key, area, volume, formula in (
        ("", *((sheet.areas[0], sheet.volumes[0], first))),
        ("_2", *((sheet.areas[1], sheet.volumes[1], annulus))),
    ):
        dead = f"{100 * DEAD_SHARE:g} % of area · stroke (guess: ports)"
        if sheet.dead_volume is not None:
            dead = f"dead volume {_shown(sheet.dead_volume, 'cm³')}"
        half = f"area · ½ stroke + {dead}{hose}"
        named = [
            (f"piston_area{key}", _shown(area, "mm²"), formula),
            (f"chamber_volume{key}", _shown(volume, "cm³"), half),
        ]
        lines += [f"  {name}: {number}  # {text}" for name, number, text in named]
    return lines[:2] if sheet.double_rod else lines


def _oil_table(sheet: CylinderSheet) -> list[str]:
    """β, density and viscosity of the oil over temperature and pressure, in lines of a comment."""
    oil, lines = sheet.fluid, ["#     °C   bar   β [MPa]   density [kg/m³]   viscosity [mPa·s]"]
    for celsius in sorted({20.0, round(sheet.temperature - KELVIN, 1), 70.0}):
        for pressure in (0.0, sheet.supply):
            at = KELVIN + celsius, pressure
            modulus, viscosity = 1e-6 * oil.bulk_modulus(*at), 1e3 * oil.viscosity(*at)
            row = f"#   {celsius:4.0f}{1e-5 * pressure:6.0f}{modulus:10.0f}{oil.density(*at):18.0f}"
            lines.append(f"{row}{viscosity:20.3g}")
    return lines


def _load_formula(sheet: CylinderSheet) -> str:
    """How the random load follows."""
    ratio = sheet.areas[1] / sheet.areas[0]
    share = f"{100.0 * sheet.load_share:.3g} % of supply pressure · A_2 = {_shown(sheet.pull, 'kN')}"
    if sheet.load_share < 0.3 - 1e-12:
        share += f" (0.7 · (A_2/A_1 = {ratio:.3f})²: from (A_2/A_1)² on, a pulling load cavitates chamber 1)"
    return share
