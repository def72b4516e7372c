"""Turning a laboratory's own files into experiment records."""

from wirewear.records.importing.importing import import_record

__all__ = ["import_record"]
