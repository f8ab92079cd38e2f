"""The controller of a standing robot, and the plan of its base and feet over time."""
