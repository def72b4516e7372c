"""Scoring of diagnoses against the sealed key of a batch."""

from studies.blind.scoring.judging import Judgement, Truth
from studies.blind.scoring.score import Score, judge_all, score_batch, verified
from studies.blind.scoring.table import score_table

__all__ = ["Judgement", "Score", "Truth", "judge_all", "score_batch", "score_table", "verified"]
