"""One page a run, to be opened in any browser: loops, scars, evolution, balances and settings, within one file."""

from wirewear.report.line_page import line_contacts_at, line_page
from wirewear.report.page import PAGE_NAME, run_page, write_page
from wirewear.report.told import runs_json, sentence_of

__all__ = ["PAGE_NAME", "line_contacts_at", "line_page", "run_page", "runs_json", "sentence_of", "write_page"]
