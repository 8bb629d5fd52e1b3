"""Servers of OPC UA: connections, subscriptions, and values joined to samples."""
