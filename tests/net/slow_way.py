#!/usr/bin/env python3
"""A bad network on this machine: UDP packets arrive late, in another order, or never.

  slow_way.py PORT DELAY_MS JITTER_MS                                     forwards packets to the server at PORT and back
  slow_way.py --between A B --at PORT DELAY_MS JITTER_MS LOSS_PERCENT     receives at PORT, forwards packets of port A to B and of B to A

It prints the port at which it receives, and runs until it is killed. The server sees each client at a separate port, as behind a router."""
import argparse
import heapq
import random
import select
import socket
import threading
import time


class SlowWay:
    """with SlowWay(delay_ms=40, jitter_ms=20, server=port) as way: clients send to way.port."""

    def __init__(self, delay_ms, jitter_ms, server=None, between=None, at=0, loss_percent=0):
        self.server, self.between = server, between
        self.delay, self.jitter, self.loss = delay_ms / 1000, jitter_ms / 1000, loss_percent / 100
        self.front = self._socket(at)
        self.port = self.front.getsockname()[1]
        self.by_client, self.client_of = {}, {}
        self.late = []  # heap of (due, number, socket, address, bytes), the earliest first
        self.number, self.over = 0, threading.Event()
        self.chance = random.Random(1)
        self.thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()
        for each in [self.front, *self.client_of]:
            each.close()

    @staticmethod
    def _socket(port=0):
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        made.bind(("127.0.0.1", port))
        made.setblocking(False)
        return made

    def _way_on(self, arrived, sender):
        """Returns the socket that sends the packet on, and the port of its destination."""
        if self.between:
            return self.front, self.between[1] if sender == self.between[0] else self.between[0]
        if arrived is not self.front:
            return self.front, self.client_of[arrived]
        if sender not in self.by_client:
            self.by_client[sender] = self._socket()
            self.client_of[self.by_client[sender]] = sender
        return self.by_client[sender], self.server

    def _take(self, arrived):
        data, (_, sender) = arrived.recvfrom(2048)
        leaves, to = self._way_on(arrived, sender)
        if self.chance.random() < self.loss:
            return
        due = time.monotonic() + self.delay + self.chance.random() * self.jitter
        self.number += 1
        heapq.heappush(self.late, (due, self.number, leaves, ("127.0.0.1", to), data))

    def _run(self):
        while not self.over.is_set():
            patience = 0.05 if not self.late else min(0.05, max(0, self.late[0][0] - time.monotonic()))
            for ready in select.select([self.front, *self.client_of], [], [], patience)[0]:
                try:
                    self._take(ready)
                except (BlockingIOError, ConnectionError):
                    pass  # no socket has the destination port any more
            while self.late and self.late[0][0] <= time.monotonic():
                _, _, leaves, to, data = heapq.heappop(self.late)
                leaves.sendto(data, to)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--between", nargs=2, type=int)
    parser.add_argument("--at", type=int, default=0)
    parser.add_argument("numbers", nargs="+", type=int)
    arguments = parser.parse_args()
    if arguments.between:
        delay, jitter, loss = arguments.numbers
        way = SlowWay(delay, jitter, between=arguments.between, at=arguments.at, loss_percent=loss)
    else:
        server, delay, jitter = arguments.numbers
        way = SlowWay(delay, jitter, server=server)
    with way:
        print(way.port, flush=True)
        threading.Event().wait()


if __name__ == "__main__":
    main()
