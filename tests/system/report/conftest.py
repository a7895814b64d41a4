"""Reports of every kind of source, as quickly as they can be had."""

from quick_reports import quick, report_of  # noqa: F401
