"""Training of the ant's gait: `python -m tests.tools.gait`."""
