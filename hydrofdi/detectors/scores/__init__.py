"""Scores: one number per record, computed from several numbers; larger is more suspicious.

A score is trained on fit records: healthy ones, and faulty ones if it needs them. It uses only numbers and
these labels, not the plant or the severity of a fault.
"""
