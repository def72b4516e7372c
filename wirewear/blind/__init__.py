"""The blind check: records whose effect is withheld, and the scoring of diagnoses made of them."""

from wirewear.blind.generator import LIBRARY_EFFECTS, LINE_TIERS, TIERS, Generator, MadeRecord
from wirewear.blind.make import default_key_path, make_batch
from wirewear.blind.scoring import Judgement, Score, Truth, score_batch, score_table, verified
from wirewear.blind.tiers import generator_of

__all__ = [
    "LIBRARY_EFFECTS",
    "LINE_TIERS",
    "TIERS",
    "Generator",
    "Judgement",
    "MadeRecord",
    "Score",
    "Truth",
    "default_key_path",
    "generator_of",
    "make_batch",
    "score_batch",
    "score_table",
    "verified",
]
