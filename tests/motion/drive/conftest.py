"""Programs that tests start in processes of their own hold no tests, and need what those interpreters have."""

collect_ignore = ["older_robot.py", "published_simulator.py"]
