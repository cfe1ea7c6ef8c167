"""Right answers to lab 06, continued: controllers and trackers."""

CANARY = "canary-b038d3ff18b15a83ee0e99d8"
