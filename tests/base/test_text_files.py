"""Files that people write: one reader, one wording, whatever is in them."""

from __future__ import annotations

from pathlib import Path

import pytest

from surefoot.base.errors import ProblemError, check_name
from surefoot.base.text_files import table_of
from surefoot.mechanics.stance.files import read_stance
from surefoot.records.log.mapping import read_mapping
from surefoot.worlds.sweep.config import read_sweep


@pytest.mark.parametrize("read", [read_mapping, read_stance, read_sweep])
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [", "is not YAML"),
        ("[" * 3000, "is not YAML"),
        ("- 1", "must be a mapping of the keys "),
        ("1: 2", "must be a mapping of the keys "),
        ("colour: red", "unknown key 'colour'; valid names: "),
    ],
)
@pytest.mark.sampled(3)
def test_every_reader_says_it_alike(read: object, text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(text)
    assert callable(read)
    with pytest.raises(ProblemError, match=message):
        read(tmp_path / "a.yaml")
    with pytest.raises(ProblemError, match=r"cannot read .*b.yaml: No such file"):
        read(tmp_path / "b.yaml")


def test_names_and_tables_are_refused_by_name() -> None:
    with pytest.raises(ProblemError, match=r"ice: unknown key \['a'\]; valid names: mu"):
        check_name("key", ["a"], {"mu": 1}, "ice")
    with pytest.raises(ProblemError, match="ice: mu is missing"):
        table_of("ice", {}, ["mu"], required=["mu"])
    assert table_of("facts", {"any": 1}) == {"any": 1}
