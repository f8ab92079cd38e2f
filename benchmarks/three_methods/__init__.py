"""One jump by three methods: a given schedule, own shooting, the direct method; docs/three-methods.md."""
