"""Programs that tests start in processes of their own hold no tests, and need what is installed there."""

collect_ignore = ["older_robot.py", "published_simulator.py"]
