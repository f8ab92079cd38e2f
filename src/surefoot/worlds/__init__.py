"""Where a controller runs without a robot: simulated worlds, runs in them, and studies over many runs.

Begin with `interface` (what a world is, and the table of their names) and `running` (the loop of a run, its
scenario, sensors and faults). `rigid`, `mujoco`, `drake` and `bullet` are the worlds; `mujoco` also records
anybody's MuJoCo loop. `replay` runs a log's motion in another world, `sweep` thousands of samples,
`experiments` holds worlds against closed forms. No other wing but `app` imports this one.
"""
