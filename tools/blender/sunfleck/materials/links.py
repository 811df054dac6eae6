"""What a socket is linked to: through reroutes and muted nodes, into groups and out of them.

In go sockets, out come links and sockets. Invariant: each link is one that counts in Cycles.
"""

from contextlib import contextmanager

from .sources import NotSimple


def link_to(socket):
    """The link that counts; reroutes and muted nodes are passed through. What leads nowhere is none, as in Cycles."""
    while socket is not None and socket.is_linked and socket.links and not socket.links[0].is_muted:
        link = socket.links[0]
        if link.from_node.type == "REROUTE":
            socket = link.from_node.inputs[0]
        elif link.from_node.mute:
            within = link.from_node.internal_links
            socket = next((one.from_socket for one in within if one.to_socket == link.from_socket), None)
        else:
            return link
    return None


# The group nodes within which one looks, the innermost last.
_groups = []


@contextmanager
def behind(output):
    """The socket that an output of a group, or of its input node, takes its value from."""
    node = output.node
    if node.type == "GROUP":
        nodes = node.node_tree.nodes if node.node_tree else ()
        ends = [one for one in nodes if one.type == "GROUP_OUTPUT" and one.is_active_output]
        before, after, sockets = _groups[:], [*_groups, node], ends[0].inputs if ends else ()
    elif _groups:
        before, after, sockets = _groups[:], _groups[:-1], _groups[-1].inputs
    else:
        raise NotSimple(node)
    found = next((socket for socket in sockets if socket.identifier == output.identifier), None)
    if found is None:
        raise NotSimple(node)
    _groups[:] = after
    try:
        yield found
    finally:
        _groups[:] = before
