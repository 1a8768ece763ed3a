from core.monitor.explain import Diagnosis, diagnose, explain
from core.monitor.leaves import LeafStatus, leaf_status
from core.monitor.signals import FailureSignals, Signals, with_children
from core.monitor.table import MonitorRow, monitor_rows

__all__ = [
    "Diagnosis",
    "FailureSignals",
    "LeafStatus",
    "MonitorRow",
    "Signals",
    "diagnose",
    "explain",
    "leaf_status",
    "monitor_rows",
    "with_children",
]
