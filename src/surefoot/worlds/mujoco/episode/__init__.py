"""The contacts of a MuJoCo loop alone, in one compiled pass a step: cheap enough for training."""
