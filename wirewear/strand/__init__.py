"""From a strand or rope to its contacts: closed forms of strand mechanics, and a study of each contact."""

from wirewear.strand.rope_contacts import RopeContacts, strand_contacts

__all__ = ["RopeContacts", "strand_contacts"]
