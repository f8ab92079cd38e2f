"""The Python on the pages about schedules, the shooting solver and the contact-implicit controller runs."""

import pytest

from tests.pages import run_page


@pytest.mark.long
def test_the_python_of_the_page_on_schedules_runs() -> None:
    pytest.importorskip("casadi")
    names = run_page("schedules.md")
    assert names["motion"].found


@pytest.mark.long
@pytest.mark.parametrize("page", ["shooting.md", "contact-implicit-mpc.md"])
def test_the_python_of_a_page_runs(page: str) -> None:
    names = run_page(page)
    if page == "shooting.md":
        assert names["found"].gains.shape == (16, 12, 36)
    else:
        assert names["log"]["planned"].shape == (300, 4)
