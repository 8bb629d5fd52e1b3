"""Streams in plain Python, sample by sample: what the compiled-out versions have to agree with."""

import math

from hydrofdi.records.streams import Chunk


def accepted(time, frequency):
    """Places of samples that are accepted, and whether each of them begins anew; occurrences by kind."""
    last, places, totals = -math.inf, [], {}
    for place, stamp in enumerate(time.tolist()):
        if not math.isfinite(stamp):
            kind = "malformed"
        elif stamp == last:
            kind = "duplicate"
        elif stamp < last:
            kind = "time_ran_back"
        else:
            begins = stamp - last > 1.5 / frequency
            kind = "gap" if begins and places else None
            places.append((place, begins))
            last = stamp
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


def run(stream, windower, parts):
    """Pieces, windows and findings of a stream in chunks."""
    state, held = stream.start(), windower.start()
    pieces, windows, findings = [], [], []
    for chunk in parts:
        state, new, said = stream.step(state, chunk)
        findings += said
        pieces += new
        for piece in new:
            held, ended = windower.step(held, piece)
            windows += ended
    return pieces, windows, findings, (state, held)
