"""Intermediate pictures of the program, which it sends with `--live`.

In go packets of the viewer tev, out comes the newest picture. Invariant: the program never waits for it;
an invalid packet only ends the reception.
"""

import socket
import struct
import threading

import numpy

from .picture import Picture

CREATE_IMAGE, UPDATE_IMAGE = 4, 6
# Header of a packet: its length, header included, and its kind.
HEAD = struct.Struct("<IB")


class Look:
    """Receives one picture of a given size."""

    def __init__(self, width, height):
        self.size, self.rows_before = (height, width), None
        self.listener, self.fresh, self.lock = None, None, threading.Lock()
        try:
            self.listener = socket.create_server(("127.0.0.1", 0))
        except OSError:
            # Without a socket, the picture shows when it is finished.
            return
        self.thread = threading.Thread(target=self._listen, daemon=True)
        self.thread.start()

    @property
    def flags(self):
        """Flags for the program."""
        return ["--live={}:{}".format(*self.listener.getsockname())] if self.listener else []

    def newest(self):
        """Newest picture since the last call; None without one."""
        with self.lock:
            found, self.fresh = self.fresh, None
        return found

    def close(self):
        if self.listener is None:
            return
        try:
            # Ends a thread that waits for the first connection.
            self.listener.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self.listener.close()

    def _listen(self):
        try:
            connection, _ = self.listener.accept()
            with connection, connection.makefile("rb") as stream:
                while head := stream.read(HEAD.size):
                    length, kind = HEAD.unpack(head)
                    packet = Packet(stream.read(length - HEAD.size))
                    if kind == CREATE_IMAGE:
                        self.rows_before = None
                    elif kind == UPDATE_IMAGE:
                        self._update(packet)
        except (OSError, ValueError, struct.error):
            pass

    def _update(self, packet):
        """Reads rows; the first rows to arrive are the uppermost."""
        packet.at += 1
        packet.text()
        names = packet.names()
        _, row, width, rows = packet.numbers("<i4", 4).tolist()
        packet.numbers("<i8", 2 * len(names))
        if self.rows_before is None:
            self.rows_before = row
        row -= self.rows_before
        if row == 0:
            self.pixels = numpy.empty((*self.size, len(names)), "f4")
        found = packet.numbers("<f4", len(names) * width * rows).reshape(len(names), rows, width)
        self.pixels[row : row + rows] = found.transpose(1, 2, 0)
        if row + rows == self.size[0]:
            with self.lock:
                self.fresh = Picture(names, self.pixels)


class Packet:
    """Fields of a packet, in order."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def numbers(self, kind, count):
        found = numpy.frombuffer(self.data, kind, count, self.at)
        self.at += found.nbytes
        return found

    def text(self):
        end = self.data.index(0, self.at)
        found, self.at = self.data[self.at : end].decode(), end + 1
        return found

    def names(self):
        return [self.text() for _ in range(int(self.numbers("<i4", 1)[0]))]
