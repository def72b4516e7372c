"""Import of a laboratory's own files as experiment records, by a mapping file."""

from wirewear.records.importing.importing import import_record

__all__ = ["import_record"]
