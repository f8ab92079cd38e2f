"""Contact-implicit problems as NLPs: complementarity forms, continuation, small textbook problems."""
