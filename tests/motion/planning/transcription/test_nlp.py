"""The derivatives that are put together from one knot's are those of the whole NLP."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.motion.planning.direct import DirectProblem, Facets, GivenModes, planar_hopper
from surefoot.motion.planning.direct.direct_transcription import DirectNlp
from surefoot.motion.planning.transcription.nlp import build_nlp

casadi = pytest.importorskip("casadi")
LAWS = (Facets(), GivenModes(), Facets("fischer-burmeister"))


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_gradient_jacobian_and_hessian(law) -> None:
    hopper = planar_hopper()
    problem = DirectProblem(hopper, hopper.nominal, np.zeros(5), knots=3, dt=0.03)
    block = DirectNlp(problem, law).block
    nlp, own = build_nlp(block, 3)
    x, p, shared, length = nlp["x"], nlp["p"], block.parameter.shape[0], block.data.shape[0]
    z = casadi.vertcat(block.x, block.u, block.after)
    value = casadi.Function("value", [z, block.parameter, block.data], [block.cost, block.rows])
    seen = [x[k * block.stride : k * block.stride + block.size] for k in range(3)]
    data = [p[shared + k * length : shared + (k + 1) * length] for k in range(3)]
    costs, rows = zip(*(value(at, p[:shared], one) for at, one in zip(seen, data, strict=True)), strict=True)
    f, g = sum(costs), casadi.vertcat(*rows)
    weight, weights = casadi.MX.sym("a"), casadi.MX.sym("b", g.shape[0])
    whole = casadi.Function(
        "whole", [x, p, weight, weights],
        [f, casadi.gradient(f, x), g, casadi.jacobian(g, x),
         casadi.triu(casadi.hessian(weight * f + casadi.dot(weights, g), x)[0])],
    )  # fmt: skip
    rng = np.random.default_rng(0)
    at = rng.normal(size=x.shape[0]), np.abs(rng.normal(size=p.shape[0]))
    multipliers = 0.7, rng.normal(size=g.shape[0])
    wanted = [np.array(value) for value in whole(*at, *multipliers)]
    found = [
        np.array(v) for v in (*own["grad_f"](*at), *own["jac_g"](*at), own["hess_lag"](*at, *multipliers))
    ]
    for ours, theirs in zip(found, wanted, strict=True):
        assert np.abs(ours - theirs).max() <= 1e-11 * max(1.0, np.abs(theirs).max())
        assert np.abs(theirs).max() > 0.0
