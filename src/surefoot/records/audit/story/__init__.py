"""Why a run went wrong: events over time, and the cause that came first.

Read `signals` for what is read off a log, `failure` for how a run went wrong at all, then `causes`: one table
of what can be at fault, each with the evidence that it needs and what would refute it. `story` puts them in
order, `told` says them.
"""
