"""MQTT: samples of a topic, and lines and samples that are sent at least once."""
