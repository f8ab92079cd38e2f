"""Every recipe of the cookbook runs as it stands and prints what stands there."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from docs.site.recipe import COOKBOOK, Recipe, read_recipe, recipes, run_recipe

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.long
@pytest.mark.parametrize("recipe", recipes(), ids=lambda recipe: recipe.path.stem)
def test_a_recipe_prints_what_it_says(recipe: Recipe, tmp_path: Path) -> None:
    if recipe.missing:
        pytest.skip(f"needs {', '.join(recipe.missing)}")
    printed = run_recipe(recipe, tmp_path)
    assert printed == [block.prints for block in recipe.blocks]


def test_the_index_names_every_recipe() -> None:
    index = (COOKBOOK / "README.md").read_text()
    for recipe in recipes():
        assert f"[{recipe.title}]({recipe.path.name})" in index, recipe.path.name


def test_a_wrong_output_and_a_stray_one_are_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- needs: json, no_such_module -->\n# Sum\n\n```python\nprint(1 + 1)\n```\n\n```text\n3\n```\n"
    )
    recipe = read_recipe(page)
    assert (recipe.title, recipe.missing) == ("Sum", ["no_such_module"])
    assert run_recipe(recipe, tmp_path) == ["2"] != [recipe.blocks[0].prints]
    page.write_text("# Sum\n\n```text\n3\n```\n")
    with pytest.raises(ValueError, match="output without code"):
        read_recipe(page)


def test_make_docs_installs_what_the_recipes_need() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras, names, todo = project["optional-dependencies"], set[str](), ["docs"]
    while todo:
        for requirement in (Requirement(text) for text in extras[todo.pop()]):
            names.add(requirement.name)
            todo += requirement.extras if requirement.name == "surefoot" else []
    needed = {name for recipe in recipes() for name in recipe.needs}
    assert needed
    assert needed <= names, "a recipe that the site does not run"
