"""MQTT: addresses, connections that reconnect, and messages that are sent at least once."""

from hydrofdi.monitor.mqtt.address import MqttAddress, is_mqtt
from hydrofdi.monitor.mqtt.configuration import MqttConfig
from hydrofdi.monitor.mqtt.connection import MqttConnection
from hydrofdi.monitor.mqtt.outbox import Outbox

__all__ = ["MqttAddress", "MqttConfig", "MqttConnection", "Outbox", "is_mqtt"]
