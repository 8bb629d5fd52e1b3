"""The table of exports of programs: `python -m tests.records.exports > docs/tables/exports.csv`."""

import csv
import io
import sys
import tempfile
from collections import Counter
from pathlib import Path

from hydrofdi.errors import HydrofdiError
from hydrofdi.records.source import measured_source, plain_source, write_description
from tests.records.dialects import content

SITUATIONS = {
    "commas.csv": "decimal commas between semicolons (Excel, German)",
    "quoted.csv": "quoted decimal commas between commas",
    "sep.csv": "first line `sep=;`, decimal commas",
    "thousands.csv": "thousands, as in `8,600.0`",
    "german_thousands.csv": "thousands, as in `8.600,0`",
    "exponents.csv": "exponents with D (Fortran)",
    "underscores.csv": "names such as `P1_bar` (MATLAB tables)",
    "slashes.csv": "names such as `p1/bar`",
    "units_row.csv": "a line of units, time called `timestamps` (asammdf)",
    "units_in_cells.csv": "units in the cells, as in `86.0bar`",
    "twincat.csv": "TwinCAT Scope, with its head",
    "twincat_groups.csv": "TwinCAT Scope, a time for each group of columns",
    "groups.csv": "a column `time` for each group of columns",
    "labview.lvm": "LabVIEW measurement file",
    "catman.txt": "HBM catman, ASCII",
    "duplicates.csv": "two columns of one name",
    "home_assistant.csv": "one value in a row (Home Assistant)",
    "wincc.csv": "one value in a row (WinCC)",
    "milliseconds.csv": "a column `time` without a unit, in ms",
    "epoch.csv": "the same, in ms since 1970",
    "excel.csv": "the same, in days of Excel",
    "time_of_day.csv": "times of day, past midnight",
    "date_and_time.csv": "date and time in two columns",
    "am_pm.txt": "dates such as `11/02/2026 01:59:59.500 PM` (LabVIEW, USA)",
    "short_years.csv": "dates such as `02.11.26 13:59:59.500`",
    "colons.csv": "`11/02/2026` and `13:59:59:500` in two columns (Rockwell)",
    "basic.csv": "dates such as `20261102T135959.500`",
    "minutes.csv": "a column `time` without a unit, in minutes",
    "hours.csv": "the same, in hours",
    "french.csv": "French names in the encoding of Windows (Excel)",
    "apostrophes.csv": "thousands, as in `8'600.0` (Swiss)",
    "narrow_blanks.csv": "thousands with narrow blanks (French)",
    "minus.csv": "typographic minus signs, UTF-16",
    "paths.csv": "dSPACE ControlDesk: names such as `Root/P1`",
    "missing.csv": "`#N/A`, `OL`, `-nan(ind)`, `1.#QNAN` for missing values",
}
"""File → what is special."""


def outcome(reading, file):
    try:
        (batch,) = reading(file).batches()
    except HydrofdiError:
        return "refused"
    kinds = Counter(remark.kind for remark in batch.remarks[0] if remark.kind != "unused")
    return "read" + (f", remarks {', '.join(f'`{kind}`' for kind in kinds)}" if kinds else "")


def proposed(file):
    """The records of a file as its proposed description states them."""
    write_description(file, description := file.with_suffix(".yaml"))
    return measured_source(description)


def table():
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["export", "without a description", "with the proposed one"])
    with tempfile.TemporaryDirectory() as folder:
        for name, situation in SITUATIONS.items():
            file = Path(folder) / name
            file.write_bytes(content(name))
            with_it = outcome(proposed, file)
            if with_it == "refused" and "…" in file.with_suffix(".yaml").read_text(encoding="utf-8"):
                with_it = "read, after the units of the channels are filled in"
            writer.writerow([situation, outcome(plain_source, file), with_it])
    return text.getvalue()


if __name__ == "__main__":
    sys.stdout.write(table())
