"""Answers and tables, from which text, pages, JSON, CSV and arrays follow."""
