"""The description of measured files: its keys, their checks, its schema."""
