"""Settings common to all tests."""

from hypothesis import HealthCheck, settings

# A busy machine is not a failure: examples are judged by what they return, not by how long they took.
settings.register_profile("wirewear", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("wirewear")
