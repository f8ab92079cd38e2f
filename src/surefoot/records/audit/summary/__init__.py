"""Summaries of runs: walks, stands, motors and state estimates; figures, no judgement of contact laws."""
