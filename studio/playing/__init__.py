"""Rollouts on screen: recordings, the playhead, and those kept beside it."""
