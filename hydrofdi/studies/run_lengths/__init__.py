"""Run lengths of control charts in studies: detection delays and false alarms.

Control charts see only scores over time; only here are their alarms combined with the known onsets and
labels.
"""
