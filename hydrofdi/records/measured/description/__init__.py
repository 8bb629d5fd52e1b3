"""The description of measured files: its keys, what they may not say, its schema."""
