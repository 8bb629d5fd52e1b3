"""Variables of an OPC UA server, to suggest one for an unknown name."""

from __future__ import annotations

from collections import deque
from contextlib import suppress

from asyncua import ua
from asyncua.client.client import Client
from asyncua.ua.uaerrors import UaError

from hydrofdi.settings.messages import similar

_MOST = 2_000


async def nearest_nodes(client: Client, wanted: str) -> str:
    """A suggestion of similar nodes, as the end of a sentence; empty if none is similar."""
    found: list[str] = []
    with suppress(OSError, UaError):
        found = await _variables(client)
    return similar(wanted, found)


async def _variables(client: Client) -> list[str]:
    """Node ids of variables below the folder of objects, without the standard ones."""
    found: list[str] = []
    waiting = deque([client.nodes.objects.nodeid])
    seen: set[ua.NodeId] = set()
    while waiting and len(seen) < _MOST:
        parent = waiting.popleft()
        if parent in seen:
            continue
        seen.add(parent)
        for child in await client.get_node(parent).get_children_descriptions():
            if child.NodeId.NamespaceIndex == 0:
                continue
            waiting.append(child.NodeId)
            if child.NodeClass == ua.NodeClass.Variable:
                found.append(child.NodeId.to_string())
    return found
