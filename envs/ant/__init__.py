"""Ant: a quadruped with a learnt gait below and waypoints above (paper, App. A.2, "Ant")."""

from envs.ant.robot import Ant

__all__ = ["Ant"]
