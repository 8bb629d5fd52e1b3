"""Streams of text: lines of CSV or JSON from standard input or a growing file."""
