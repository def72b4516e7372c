"""Turning a laboratory's own files into records of line contacts."""

from wirewear.line_records.importing.importing import ImportedLine, import_line_record

__all__ = ["ImportedLine", "import_line_record"]
