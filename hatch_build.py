"""What the index is told beyond pyproject.toml: the README with absolute links, and the project's addresses.

Both need the address of the repository: ``home`` in ``[tool.hatch.metadata.hooks.custom]``. While that is
empty the README goes out without what leads into the repository, and there are no addresses.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LINK = re.compile(r'(\]\(|src=")(?!https?:|#|mailto:)([^)"\s]+)')
IMAGES = (".png", ".svg", ".webp")


def with_absolute_links(text: str, home: str) -> str:
    """Return Markdown whose relative links and pictures lead to the repository at an address."""

    def absolute(match: re.Match[str]) -> str:
        path = match[2]
        kind = "raw" if path.partition("#")[0].endswith(IMAGES) else "blob"
        return f"{match[1]}{home.rstrip('/')}/{kind}/main/{path}"

    return LINK.sub(absolute, text)


def without_relative_links(text: str) -> str:
    """Return Markdown without relative pictures, and with the words alone of relative links."""
    text = re.sub(r'!\[[^\]]*\]\((?!https?:)[^)]+\)\n?|<img src="(?!https?:)[^>]*>\n?', "", text)
    return re.sub(r"\[([^\]]*)\]\((?!https?:|#|mailto:)[^)]+\)", r"\1", text)


class AddressHook(MetadataHookInterface):
    """Fills in ``readme`` and ``urls``."""

    PLUGIN_NAME = "custom"

    def update(self, metadata: dict[str, Any]) -> None:
        """Add both to the project's metadata."""
        home = str(self.config.get("home", ""))
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        text = with_absolute_links(text, home) if home else without_relative_links(text)
        if home:
            metadata["urls"] = {
                "Homepage": home,
                "Documentation": f"{home}/blob/main/docs/README.md",
                "Changelog": f"{home}/blob/main/CHANGELOG.md",
                "Issues": f"{home}/issues",
            }
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
