from core.monitor.explain import Diagnosis, diagnose, explain
from core.monitor.leaves import LeafStatus, leaf_status
from core.monitor.signals import Signals, failure_signals
from core.monitor.table import MonitorRow, monitor_rows

__all__ = [
    "Diagnosis",
    "LeafStatus",
    "MonitorRow",
    "Signals",
    "diagnose",
    "explain",
    "failure_signals",
    "leaf_status",
    "monitor_rows",
]
