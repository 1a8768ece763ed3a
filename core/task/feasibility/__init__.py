"""What is known of a mission before anything is learnt: whether it can be carried out at all."""

from core.task.feasibility.finding import Finding, Severity, refusal
from core.task.feasibility.judgement import Mission, judge
from core.task.feasibility.places import Places

__all__ = ["Finding", "Mission", "Places", "Severity", "judge", "refusal"]
