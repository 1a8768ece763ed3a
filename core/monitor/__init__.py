from core.monitor.explain import Diagnosis, diagnose
from core.monitor.leaves import LeafStatus, leaf_status
from core.monitor.prefix import falsified_at
from core.monitor.signals import FailureSignals, Signals
from core.monitor.table import MonitorRow, monitor_rows

__all__ = [
    "Diagnosis",
    "FailureSignals",
    "LeafStatus",
    "MonitorRow",
    "Signals",
    "diagnose",
    "falsified_at",
    "leaf_status",
    "monitor_rows",
]
