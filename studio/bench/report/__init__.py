"""The report of a store: one page, its pictures, a summary of every number, and Markdown."""

from studio.bench.report.markdown import write_docs
from studio.bench.report.write import write_report

__all__ = ["write_docs", "write_report"]
