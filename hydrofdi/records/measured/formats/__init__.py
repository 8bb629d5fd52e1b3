"""Formats of measured files: each gives a table of named columns."""
