"""The blind check: records whose effect is withheld, and the scoring of diagnoses made of them."""

from studies.blind.generators.generator import LIBRARY_EFFECTS, LINE_TIERS, OTHERS, TIERS, Generator, MadeRecord
from studies.blind.generators.tiers import generator_of
from studies.blind.make import default_key_path, make_batch
from studies.blind.scoring import Judgement, Score, Truth, score_batch, score_table, verified

__all__ = [
    "LIBRARY_EFFECTS", "LINE_TIERS", "OTHERS", "TIERS", "Generator", "Judgement", "MadeRecord", "Score", "Truth",
    "default_key_path", "generator_of", "make_batch", "score_batch", "score_table", "verified",
]  # fmt: skip
