"""Walking on two flat feet: pendulum preview, footsteps, soles, posture and the controller that ties them."""
