"""Configuration of Cyclone DDS: one interface, discovery without multicast, and a user's own file."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import urlsplit
from xml.etree import ElementTree

from surefoot.base.errors import ProblemError, one_line, shown

LOOPBACK = "lo"
"""The interface that leads to no other machine."""
VARIABLE = "CYCLONEDDS_URI"
"""The environment's variable that Cyclone DDS reads its configuration from."""
BASE = (
    "<CycloneDDS><Domain Id='any'>{}<Discovery><ParticipantIndex>auto</ParticipantIndex></Discovery>"
    "</Domain></CycloneDDS>"
)
"""What is set where a user's configuration does not: ports by index, so that programs on an interface without
multicast, as Linux's `lo` is, find each other."""
INTERFACE = (
    "<General><Interfaces><NetworkInterface name='{}' priority='default' multicast='default'/></Interfaces>"
    "</General>"
)


def _documents(own: str) -> list[str]:
    """Return the XML texts of a configuration as `VARIABLE` has it: XML itself, or files, comma between."""
    own = own.strip()
    if own.startswith("<"):
        return [own]
    texts = []
    for place in filter(None, (part.strip() for part in own.split(","))):
        path = Path(urlsplit(place).path if place.startswith("file:") else place)
        try:
            texts.append(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError) as error:
            raise ProblemError(
                f"the configuration of DDS {shown(place)} cannot be read: {one_line(error)}"
            ) from error
    return texts


def _own_interfaces(own: str) -> list[str]:
    """Return the interfaces that a user's configuration names: a name, an address or "any"."""
    found = []
    for text in _documents(own):
        try:
            root = ElementTree.fromstring(text)
        except ElementTree.ParseError as error:
            raise ProblemError(f"the configuration of DDS is no XML: {one_line(error)}") from error
        for element in root.iter():
            tag, said = element.tag.rpartition("}")[2].lower(), element.attrib
            if tag == "networkinterface":
                found.append(said.get("name") or said.get("address") or "any")
            elif tag == "networkinterfaceaddress":
                found += [part.strip() for part in (element.text or "any").split(",")]
    return found


def dds_config(interface: str, own: str = "") -> str:
    """Return the configuration for an interface, with a user's own that has the last word.

    Parameters
    ----------
    interface
        Of the network; not used where `own` names interfaces.
    own
        XML, or the places of files with XML, as `VARIABLE` may have them; empty for none.

    Raises
    ------
    ProblemError
        For a file that is not there or is no XML, or one that names other interfaces than the one asked for.
    """
    if not own.strip():
        return BASE.format(INTERFACE.format(interface))
    named = _own_interfaces(own)
    if named and interface not in (LOOPBACK, *named):
        raise ProblemError(
            f"the interface {interface!r} is not among those of the DDS configuration: {', '.join(named)}"
        )
    return f"{BASE.format('' if named else INTERFACE.format(interface))},{own.strip()}"


def leads_outside(interface: str, own: str = "") -> bool:
    """Return whether such a configuration may lead to another machine."""
    named = _own_interfaces(own) if own.strip() else []
    return any(name not in (LOOPBACK, "127.0.0.1") for name in named or [interface])
