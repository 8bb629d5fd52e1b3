"""Monitoring: the windows of a stream are judged and reported. The state survives a restart."""
