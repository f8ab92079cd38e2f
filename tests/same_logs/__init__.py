"""Whether two revisions give the same logs to the last digit: of walks, stands and an outing of `RobotLoop`.

    python -m tests.same_logs record DIR [--tree TREE] [--only NAMES]
    python -m tests.same_logs compare DIR1 DIR2 [--only NAMES]
    python -m tests.same_logs check DIR [--tree TREE] [--only NAMES]
    python -m tests.same_logs against REV [--tree TREE] [--only NAMES] [--cache DIR]

`record` writes the logs of a tree (this one, or any other checkout), `compare` compares two records, `check`
records a tree and compares it with a record, and `against` does both for a revision and a tree. NAMES are
scenarios or groups of them, with commas between. The exit code is 0 if all logs are the same, 1 if not.
"""
