"""Plain MuJoCo loops as a stranger would write them, and seeded failures of theirs with known causes.

Nothing here uses a controller, a world or a gait of the package; only `sf.record` sees the runs.

- `quadruped`: twelve hinges, motors, PD to joint targets; it stands or trots. `hopper`: one leg, hips and a
  telescope under torque control. `pusher`: an arm of position actuators that pushes a crate over a table.
  `humanoid`: two box feet, motors, PD; it stands and sways. Beside each its failures, `..._faults`.
- `hexapod`: six legs of position servos that walk on two tripods. `balancer`: a post on two wheels under
  state feedback. No rule of the audit was tuned on these two.
- `fault`: what a seeded failure is made of, and its truth. `ground`: what the robots stand on and what may
  fall on them. `simulation`: the loop itself. `injections`: faults that several loops share. `causes`: their
  names. `loops`: which loop a seed of a cause runs in. `race`: runs the seeds and counts what an audit tells.
"""
