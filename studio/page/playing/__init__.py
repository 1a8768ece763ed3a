"""Rollouts on screen: the one that plays, its playhead, and the ghosts."""
