#!/usr/bin/env python3
"""A way to a UDP server on this machine that takes its time: who sends here reaches the server later, and so do the answers.

The server sees each client at a port of its own, as behind a router.

  slow_way.py SERVER_PORT DELAY_MS JITTER_MS       prints its own port; until it is killed"""
import heapq
import random
import select
import socket
import sys
import threading
import time


class SlowWay:
    """with SlowWay(port, delay_ms=40, jitter_ms=20) as way: clients send to way.port."""

    def __init__(self, server_port, delay_ms, jitter_ms):
        self.server = ("127.0.0.1", server_port)
        self.delay, self.jitter = delay_ms / 1000, jitter_ms / 1000
        self.front = self._socket()
        self.port = self.front.getsockname()[1]
        self.by_client, self.client_of = {}, {}
        self.late = []  # (due, number, socket, address, bytes), the earliest first
        self.number, self.passed, self.over = 0, 0, threading.Event()
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
    def _socket():
        made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        made.bind(("127.0.0.1", 0))
        made.setblocking(False)
        return made

    def _take(self, arrived):
        data, sender = arrived.recvfrom(2048)
        if arrived is self.front:
            if sender not in self.by_client:
                self.by_client[sender] = self._socket()
                self.client_of[self.by_client[sender]] = sender
            leaves, to = self.by_client[sender], self.server
        else:
            leaves, to = self.front, self.client_of[arrived]
        due = time.monotonic() + self.delay + random.random() * self.jitter
        self.number += 1
        heapq.heappush(self.late, (due, self.number, leaves, to, data))

    def _run(self):
        while not self.over.is_set():
            patience = 0.05 if not self.late else min(0.05, max(0, self.late[0][0] - time.monotonic()))
            for ready in select.select([self.front, *self.client_of], [], [], patience)[0]:
                try:
                    self._take(ready)
                except (BlockingIOError, ConnectionError):
                    pass  # nobody listens there any more
            while self.late and self.late[0][0] <= time.monotonic():
                _, _, leaves, to, data = heapq.heappop(self.late)
                leaves.sendto(data, to)
                self.passed += 1


if __name__ == "__main__":
    server, delay, jitter = map(int, sys.argv[1:4])
    with SlowWay(server, delay, jitter) as way:
        print(way.port, flush=True)
        threading.Event().wait()
