"""Sensors: what a rig's instruments make of the true motion and forces, and how far that can be undone."""

from wirewear.sensor.sensor import Sensor, SensorNoise
from wirewear.sensor.signals import LoopSignals
from wirewear.sensor.stroke import HeldStroke, sensor_held_stroke

__all__ = ["HeldStroke", "LoopSignals", "Sensor", "SensorNoise", "sensor_held_stroke"]
