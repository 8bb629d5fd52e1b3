"""Monitoring: a stream goes in; windows are judged; lines come out. Its state survives a restart."""
