"""A study of detection: normal variation, faults, and how they are distinguished."""
