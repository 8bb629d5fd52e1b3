"""Streams judged by a trained detector, and records played as streams."""
