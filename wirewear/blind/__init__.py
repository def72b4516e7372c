"""The blind check: records whose effect is withheld, and the scoring of diagnoses made of them."""

from wirewear.blind.generator import TIERS, Generator, MadeRecord
from wirewear.blind.make import make_batch
from wirewear.blind.tiers import generator_of

__all__ = ["TIERS", "Generator", "MadeRecord", "generator_of", "make_batch"]
