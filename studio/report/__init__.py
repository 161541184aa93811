"""The report of an evaluation: tables as files, and one page that can be mailed and opened anywhere."""

from __future__ import annotations

from studio.report.write import write_report, write_tables

__all__ = ["write_report", "write_tables"]
