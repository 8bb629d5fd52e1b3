"""The same record as programs export it: text dialects by name."""

from datetime import datetime, timedelta

import numpy as np

N_TIME, RATE = 400, 500.0
TIME = np.arange(N_TIME) / RATE
TITLES = ("time [s]", "P1 [bar]", "P2 [bar]", "x [mm]", "u [V]")
UNITS = ("s", "bar", "bar", "mm", "V")


def columns():
    """Time [s], two pressures [bar], position [mm], command [V] of six decimals, shape (5, n_time)."""
    swing = np.sin(2.0 * np.pi * 3.3 * TIME) + 0.3 * np.sin(2.0 * np.pi * 23.0 * TIME + 0.5)
    way, command = 10.0 * np.cos(8.1 * TIME), 2.0 * np.sin(8.1 * TIME)
    return np.round([TIME, 80.0 + 20.0 * swing, 90.0 - 20.0 * swing, way, command], 6)


ROWS = columns().T


def cells(row, decimal=".", form="{:.6f}"):
    return [form.format(value).replace(".", decimal) for value in row]


def lines(head, sep=",", decimal=".", quote="", rows=ROWS, form="{:.6f}"):
    body = [sep.join(f"{quote}{cell}{quote}" for cell in cells(row, decimal, form)) for row in rows]
    return "\n".join([*head, *body]) + "\n"


def twincat():
    ms = np.column_stack([ROWS[:, 0] * 1e3, ROWS[:, 1:]])
    head = ["Name\tscope", "File\tC:\\data\\scope.csv", "Endtime of export\t13295973385375", "", "",
            "Name\tP1\tP2\tx\tu", "SymbolComment\t\t\t\t", "Data-Type\tREAL64\tREAL64\tREAL64\tREAL64",
            "SampleTime[ms]\t2\t2\t2\t2", "Unit\tbar (Pressure)\tbar (Pressure)\tmm (Length)\tV (Voltage)",
            "Unit ScaleFactor\t1\t1\t1\t1", ""]  # fmt: skip
    return lines(head, "\t", ",", rows=ms)


def labview():
    head = ["LabVIEW Measurement\t", "Writer_Version\t2", "Separator\tTab", "Decimal_Separator\t,",
            "X_Columns\tOne",
            "Date\t2026/11/02", "Time\t10:38:17,1234567890123", "***End_of_Header***\t", "\t",
            "Channels\t4\t\t\t\t",
            "Samples\t400\t400\t400\t400\t", "Y_Unit_Label\tbar\tbar\tmm\tV\t",
            "Delta_X\t0,002\t0,002\t0,002\t0,002\t",
            "***End_of_Header***\t\t\t\t\t", "X_Value\tP1\tP2\tx\tu\tComment"]  # fmt: skip
    return lines(head, "\t", ",")


def catman():
    head = ["HBM_CATMANDATAFILE_60_", "", "Testbench 3", "T-ID=0", "SAMPLERATE=500", "",
            "Time  1 - default sample rate\tP1\tP2\tx\tu", "s\tbar\tbar\tmm\tV",
            "CH=1\tCH=2\tCH=3\tCH=4\tCH=5"]  # fmt: skip
    return lines(head, "\t")


def groups(title):
    """Pressures at 500 Hz, and position and command at 100 Hz with their own times [ms]."""
    head = f"{title}\tP1 [bar]\tP2 [bar]\t{title}\tx [mm]\tu [V]\n"
    fast, slow = (
        [cells([row[0] * 1e3, *row[1:3]]) for row in ROWS],
        [cells([row[0] * 1e3, *row[3:]]) for row in ROWS[::5]],
    )
    slow += [["", "", ""]] * (len(fast) - len(slow))
    return head + "".join("\t".join(left + right) + "\n" for left, right in zip(fast, slow, strict=True))


def long(sep, head, entry):
    return sep.join(head) + "\n" + "".join(
        sep.join(entry(name, time, value)) + "\n"
        for time, *values in ROWS for name, value in zip(("P1", "P2"), values, strict=False)
    )  # fmt: skip


def date(n, form):
    """A date with three decimals, whose format ends with the seconds."""
    at = datetime(2026, 11, 2, 13, 59, 59, 500_000) + timedelta(seconds=n / RATE)
    return at.strftime(form).replace("%%", f"{at.microsecond // 1000:03}")


def thousands(sign, decimal, sep):
    kpa = np.column_stack([ROWS[:, 0], ROWS[:, 1:3] * 100.0])
    form = [[f"{value:,.6f}".translate(str.maketrans(",.", sign + decimal)) for value in row] for row in kpa]
    return sep.join(["time [s]", "P1 [kPa]", "P2 [kPa]"]) + "\n" + "".join(
        sep.join(f'"{cell}"' for cell in row) + "\n" for row in form
    )  # fmt: skip


def of_time(title, form):
    return "\n".join([
        f"{title},P1 [bar],P2 [bar]",
        *(f"{form(n)},{row[1]:.6f},{row[2]:.6f}" for n, row in enumerate(ROWS)),
    ]) + "\n"  # fmt: skip


def of_day(n, start=86_399_900):
    """A time of day that passes midnight."""
    ms = (start + 2 * n) % 86_400_000
    return f"{ms // 3_600_000:02}:{ms // 60_000 % 60:02}:{ms // 1000 % 60:02}.{ms % 1000:03}"


TEXTS = {
    "plain.csv": lines([",".join(TITLES)]),
    "sep_point.csv": lines(["sep=;", ";".join(TITLES)], ";"),
    "commas.csv": lines([";".join(TITLES)], ";", ","),
    "quoted.csv": lines([",".join(TITLES)], ",", ",", '"'),
    "sep.csv": lines(["sep=;", ";".join(TITLES)], ";", ","),
    "thousands.csv": thousands(",", ".", ","),
    "german_thousands.csv": thousands(".", ",", ";"),
    "exponents.csv": lines([",".join(TITLES)], form="{:.9e}").replace("e+", "D+").replace("e-", "D-"),
    "underscores.csv": lines(["time_s,P1_bar,P2_bar,x_mm,u_V"]),
    "slashes.csv": lines(["t/s;p1/bar;p2/bar;x/mm;u/V"], ";", ","),
    "units_row.csv": lines(["timestamps,P1,P2,x,u", "s,bar,bar,mm,V"]),
    "units_in_cells.csv": "time,P1,P2,x,u\n" + "".join(
        ",".join(cell + unit for cell, unit in zip(cells(row), UNITS, strict=True)) + "\n" for row in ROWS
    ),
    "twincat.csv": twincat(),
    "twincat_groups.csv": groups("Name"),
    "groups.csv": groups("time [ms]"),
    "labview.lvm": labview(),
    "catman.txt": catman(),
    "duplicates.csv": lines(["time [s],P1 [bar],P1 [bar],x [mm],u [V]"]),
    "home_assistant.csv": long(
        ",", ("entity_id", "state", "last_changed"),
        lambda name, time, value: (f"press.{name}", f"{value:.6f}", f"2026-05-05T22:00:0{time:.3f}Z"),
    ),
    "wincc.csv": long(
        ";", ('"VarName"', '"TimeString"', '"VarValue"', '"Validity"', '"Time_ms"'),
        lambda name, time, value: (
            f'"{name}"', '"05.05.2026 22:00:00"', f"{value:.6f}".replace(".", ","), "1",
            f"{46_327_500_000.0 + time / 0.0864:.6f}".replace(".", ","),
        ),
    ),
    "milliseconds.csv": of_time("time", lambda n: 2 * n),
    "epoch.csv": of_time("time", lambda n: 1_764_187_200_000 + 2 * n),
    "excel.csv": of_time("time", lambda n: f"{46_327.5 + n * 0.002 / 86_400.0:.12f}"),
    "time_of_day.csv": of_time("time", of_day),
    "date_and_time.csv": of_time("Date,Time", lambda n: f"2026-05-05,{of_day(n, 43_200_000)}"),
    "am_pm.txt": of_time("Time", lambda n: date(n, "%m/%d/%Y %I:%M:%S.%%%% %p")),
    "short_years.csv": of_time("time", lambda n: date(n, "%d.%m.%y %H:%M:%S.%%%%")),
    "colons.csv": of_time("Date,Time", lambda n: date(n, "11/02/2026,%H:%M:%S:%%%%")),
    "basic.csv": of_time("time", lambda n: date(n, "%Y%m%dT%H%M%S.%%%%")),
    "minutes.csv": of_time("time", lambda n: f"{n / RATE / 60.0:.12f}"),
    "hours.csv": of_time("time", lambda n: f"{n / RATE / 3600.0:.13f}"),
    "french.csv": lines(
        ["Temps (s);Pression A (bar);Pression B (bar);Déplacement (mm);Tension (V)"], ";", ","
    ),
    "apostrophes.csv": thousands("'", ".", ";"),
    "narrow_blanks.csv": thousands("\u202f", ",", ";"),
    "minus.csv": lines([",".join(TITLES)]).replace("-", "\u2212"),
    "paths.csv": lines(
        ["XIL API,ControlDesk", "time,Root/P1,Root/P2,Root/x,Root/u", "[s],[bar],[bar],[mm],[V]"]
    ),
    "missing.csv": lines([",".join(TITLES)]) + "0.8,#N/A,OL,-nan(ind),1.#QNAN\n0.802,80,90,1,1\n",
}  # fmt: skip
"""File → text: two plain ones, then those of `docs/tables/exports.csv` in its order."""
ENCODINGS = {"french.csv": "cp1252", "minus.csv": "utf-16"}


def content(name):
    return TEXTS[name].encode(ENCODINGS.get(name, "utf-8"))
