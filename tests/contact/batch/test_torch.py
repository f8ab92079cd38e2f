"""The problem in PyTorch: the same forces as `surefoot.solve`, and gradcheck in double precision."""

from __future__ import annotations

from typing import Any

import pytest

from surefoot.base.errors import ProblemError
from surefoot.contact.batch.answers import STATUSES
from surefoot.contact.solution import Status

torch = pytest.importorskip("torch", reason="PyTorch is not installed (extra torch; make test-extras)")
sft = pytest.importorskip("surefoot.contact.batch.torch")


def _tensors(problems: Any, count: int | None = None, **options: Any) -> list[Any]:
    return [torch.tensor(v[:count], requires_grad=True, **options) for v in problems]


@pytest.mark.parametrize("smoothing", [0.0, 1e-3])
def test_gradients_in_its_own_arrays(problems: Any, smoothing: float) -> None:
    """The array form, as on a device: in double precision gradcheck holds there, too."""

    def answer(G: Any, g: Any, mu: Any) -> Any:
        found = sft.solve(0.5 * (G + G.mT), g, mu, smoothing=smoothing, on_host=False)
        return found.forces, found.velocities

    assert torch.autograd.gradcheck(
        answer, _tensors(problems, 2), eps=1e-7, atol=1e-4, rtol=1e-4, fast_mode=True
    )
    single = sft.solve(*_tensors(problems, dtype=torch.float32), smoothing=smoothing, on_host=False)
    assert single.forces.dtype == torch.float32
    assert (single.status == 0).all()
    with pytest.raises(ProblemError, match="smoothing must be >= 0"):
        sft.solve(*_tensors(problems), smoothing=-1.0)


@pytest.mark.parametrize("on_host", [True, False])
def test_never_nan(hard: Any, on_host: bool) -> None:
    for name, given in hard:
        tensors = _tensors(given)
        found = sft.solve(*tensors, on_host=on_host)
        (found.forces.sum() + found.velocities.sum()).backward()
        numbers = (found.forces, found.velocities, *(t.grad for t in tensors))
        assert all(torch.isfinite(v).all() for v in numbers), name
        bad = name in ("nan in g", "infinite G", "negative mu")
        assert (STATUSES[int(found.status[0])] is Status.INVALID) == bad, name
        assert not (bad and found.forces.any()), name


def test_single_precision_is_rounded_double(problems: Any) -> None:
    tensors = _tensors(problems, dtype=torch.float32)
    found = sft.solve(*tensors)
    again = sft.solve(*(t.detach().double() for t in tensors))
    assert found.forces.dtype == torch.float32
    assert torch.equal(found.forces, again.forces.float())
    found.forces.sum().backward()
    assert tensors[0].grad.dtype == torch.float32


def test_masks_and_numbers(problems: Any) -> None:
    G, g, _ = _tensors(problems, 4)
    found = sft.solve(G, g, 0.5, mask=torch.tensor([True, True, False, True]))
    assert (found.modes[:, 2] == 0).all()
    assert (found.forces[:, 2] == 0.0).all()
    found.forces.sum().backward()
    assert (g.grad.reshape(4, 4, 3)[:, 2] == 0.0).all()


def test_wrong_input_is_named(problems: Any) -> None:
    G, g, mu = _tensors(problems, 2)
    with pytest.raises(ProblemError, match="G must be a tensor, got ndarray"):
        sft.solve(problems.G, g, mu)
    with pytest.raises(ProblemError, match="g must be float32 or float64, got int64"):
        sft.solve(G, g.long(), mu)
    with pytest.raises(ProblemError, match="G must have shape"):
        sft.solve(G[0], g, mu)
