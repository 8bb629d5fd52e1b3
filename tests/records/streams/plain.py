"""Streams in plain Python, sample by sample: what the compiled-out versions have to agree with."""

import math

from hydrofdi.records import Channel
from hydrofdi.records.streams import Chunk, CycleWindower, EvenStream, TimeWindower


def accepted(time, frequency):
    """Places of samples that are accepted, and whether each of them begins anew; occurrences by kind."""
    period, patience = 1 / frequency, max(10, round(60 * frequency))
    last, places, totals, earlier, gaps = -math.inf, [], {}, 0, 0
    for place, stamp in enumerate(time.tolist()):
        kind, begins = None, False
        if not math.isfinite(stamp):
            kind = "malformed"
        elif stamp == last:
            kind = "duplicate"
        elif stamp < last:
            kind, earlier = "time_ran_back", earlier + 1
        if kind is None or earlier == patience:
            begins = kind is not None or stamp - last > 1.5 * period
            is_gap = begins and kind is None and bool(places)
            gaps = gaps + 1 if is_gap else 0
            kind = kind or ("rate_changed" if gaps >= 10 else "gap" if is_gap else None)
            places.append((place, begins))
            last, earlier = stamp, 0
        if kind:
            totals[kind] = totals.get(kind, 0) + 1
    return places, totals


def time_windows(places, n_sample, n_every):
    """Lists of places, one for each window."""
    windows, held = [], []
    for place, begins in places:
        if begins:
            held = []
        held.append(place)
        if len(held) >= n_sample and (len(held) - n_sample) % n_every == 0:
            windows.append(held[-n_sample:])
    return windows


def cycle_windows(places, drive, drive_range, n_sample, edge):
    """Lists of places, one for each window; short ones are short cycles."""
    middle, half = sum(drive_range) / 2, 0.1 * (drive_range[1] - drive_range[0])
    windows, held, side = [], None, 0
    for place, begins in places:
        if begins:
            held, side = None, 0
        value = float(drive[place])
        now = (value > middle + half) - (value < middle - half)
        if now and side and now != side and edge in ("both", "rising" if now > 0 else "falling"):
            if held is not None:
                windows.append(held)
            held = []
        side = now or side
        if held is not None:
            held.append(place)
            if len(held) == n_sample:
                windows.append(held)
                held = None
    return windows


def chunks(time, channels, sizes):
    """A stream in chunks of these sizes, again and again."""
    first, turn = 0, 0
    while first < len(time):
        stop = first + sizes[turn % len(sizes)]
        yield Chunk(time[first:stop], {channel: row[first:stop] for channel, row in channels.items()})
        first, turn = stop, turn + 1


def run(stream, windower, parts, states=None):
    """Pieces, windows and findings of a stream in chunks, and the states behind it."""
    state, held = states or (stream.start(), windower.start())
    pieces, windows, findings = [], [], []
    for chunk in parts:
        state, new, said = stream.step(state, chunk)
        findings += said
        pieces += new
        for piece in new:
            held, ended = windower.step(held, piece)
            windows += ended
    return pieces, windows, findings, (state, held)


def make_windower(by, n_sample, n_every=None, *, channels, sampling_frequency, drive=None, edge="rising"):
    if by == "time":
        return TimeWindower(n_sample, n_every or n_sample, channels, sampling_frequency)
    return CycleWindower(n_sample, channels, sampling_frequency, Channel.INPUT_VOLTAGE, drive, edge)


def windows_of(time, channels, windower):
    """Windows of a whole record: those of a stream of its samples."""
    stream = EvenStream(windower.sampling_frequency, windower.needs)
    return run(stream, windower, [Chunk(time, channels)])[1]
