"""One jump on three roads: a given schedule, own shooting, the direct method; docs/three-roads.md."""
