"""MuJoCo's step with Coulomb's law in place of its soft constraints: `sf.MujocoStepper`."""
