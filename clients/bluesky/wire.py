"""BlueSky's wire: two ZeroMQ sockets, a header of addresses and topic, msgpack. Written for 1.1.1."""

import os
import struct

import msgpack
import zmq
import zmq.utils.monitor

IDLEN = 5
SIM = ord("S")


def _array(value):
    """Arrays of numbers come as their octets."""
    if value.get("numpy") or value.get(b"numpy"):
        kind = value.get("type", value.get(b"type"))
        data = value.get("data", value.get(b"data"))
        kind = kind.decode() if isinstance(kind, bytes) else kind
        code = {"f8": "d", "f4": "f", "i8": "q", "i4": "i", "b1": "?", "u1": "B"}.get(kind[1:])
        return list(struct.unpack(f"<{len(data) // struct.calcsize(code)}{code}", data)) if code else []
    return value


class Wire:
    """A client of a BlueSky server: what comes, what goes, and which nodes there are."""

    def __init__(self, host, receive=11000, send=11001):
        self.own = b"C" + os.urandom(3).replace(b"*", b"_") + b"\x81"
        self.nodes = []
        context = zmq.Context.instance()
        self._in, self._out = context.socket(zmq.SUB), context.socket(zmq.XPUB)
        # A server that is away is asked again every second; what waits for it is not kept.
        for socket in (self._in, self._out):
            socket.setsockopt(zmq.LINGER, 0)
            socket.setsockopt(zmq.RECONNECT_IVL, 1000)
            socket.setsockopt(zmq.SNDHWM, 200)
        self._in.connect(f"tcp://{host}:{receive}")
        self._out.connect(f"tcp://{host}:{send}")
        self._poller = zmq.Poller()
        self._poller.register(self._in, zmq.POLLIN)
        self._poller.register(self._out, zmq.POLLIN)
        self._in.setsockopt(zmq.SUBSCRIBE, self.own)
        for topic in (b"ACDATA", b"RESET", b"ECHO", b"SIMINFO"):
            self._in.setsockopt(zmq.SUBSCRIBE, b"*" * IDLEN + topic)
        self._monitor = self._in.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        self._poller.register(self._monitor, zmq.POLLIN)

    def poll(self, timeout_ms):
        """Events: ("came", node), ("left", node), ("lost",) for the server, or (topic, node, data)."""
        events = []
        for socket, _ in self._poller.poll(timeout_ms):
            if socket is self._monitor:
                zmq.utils.monitor.recv_monitor_message(self._monitor)
                self.nodes.clear()
                events.append(("lost",))
                continue
            for _ in range(500):
                try:
                    parts = socket.recv_multipart(zmq.NOBLOCK)
                except zmq.Again:
                    break
                event = self._node(parts[0]) if socket is self._out else self._message(parts)
                if event:
                    events.append(event)
        return events

    def _node(self, octets):
        if len(octets) != IDLEN + 1 or octets[1] != SIM or octets[-1] <= 0x80:
            return None
        node = octets[1:]
        if octets[0] == 1 and node not in self.nodes:
            self.nodes.append(node)
            return ("came", node)
        if octets[0] == 0 and node in self.nodes:
            self.nodes.remove(node)
            return ("left", node)
        return None

    def _message(self, parts):
        if len(parts) != 2 or len(parts[0]) < 2 * IDLEN:
            return None
        topic, sender = parts[0][IDLEN:-IDLEN].decode("ascii", "replace"), parts[0][-IDLEN:]
        try:
            data = msgpack.unpackb(parts[1], object_hook=_array, raw=False, strict_map_key=False)
        except Exception:  # whatever the octets are
            return ("damaged", sender, None)
        # Shared states come with what is done to them.
        if isinstance(data, (list, tuple)) and len(data) == 2 and isinstance(data[1], dict):
            data = data[1]
        return (topic, sender, data)

    def command(self, node, line):
        """Puts a line (commands with `;` between) on a node's stack."""
        self._out.send_multipart([node + b"STACK" + self.own, msgpack.packb(line, use_bin_type=True)])

    def close(self):
        for socket in (self._monitor, self._in, self._out):
            socket.close()
