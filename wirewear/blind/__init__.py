"""The blind check: records whose effect is withheld, and the scoring of diagnoses made of them."""

from wirewear.blind.generator import TIERS, Generator, MadeRecord
from wirewear.blind.make import default_key_path, make_batch
from wirewear.blind.scoring import Score, score_batch, score_table
from wirewear.blind.tiers import generator_of

__all__ = [
    "TIERS",
    "Generator",
    "MadeRecord",
    "Score",
    "default_key_path",
    "generator_of",
    "make_batch",
    "score_batch",
    "score_table",
]
