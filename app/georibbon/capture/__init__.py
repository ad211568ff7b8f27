"""A capture, without a window: calibration and passes as state machines over live readings."""
