#!/usr/bin/env python3
"""A bad network between two TUN devices, with the words of `tc netem`, for kernels without netem.

  tun_way.py DEVICE DEVICE [delay MS [JITTER]] [loss P%] [duplicate P%] [reorder P% [CORRELATION%]] [rate N kbit]

Creates both devices, prints "ready", and carries IPv4 packets from each device to the other until SIGTERM; then it prints counts of packets.
The devices may be moved into network namespaces meanwhile. As in netem, jitter is uniform, to both sides of the delay; a reordered packet is
sent at once and the others are delayed; a rate applies to each direction, whose queue has room for 1000 packets."""
import fcntl
import heapq
import os
import random
import select
import signal
import struct
import sys
import time

TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000
ROOM = 1000


def number(word):
    """Returns the number in a word such as 20ms, 5% or 64kbit, in the unit of the word."""
    return float(word.rstrip("ms%kbit"))


def words_of(arguments):
    """Returns {word: the numbers that follow it}."""
    found, name = {}, None
    for word in arguments:
        if word in ("delay", "loss", "duplicate", "reorder", "rate"):
            name = word
            found[name] = []
        elif name:
            found[name].append(number(word))
        else:
            sys.exit(f"tun_way.py: no word of this network: {word}")
    return found


def device(name):
    made = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(made, TUNSETIFF, struct.pack("16sH22x", name.encode(), IFF_TUN | IFF_NO_PI))
    return made


class Chance:
    """An event with a probability [%]. The correlation [%] is the share of the previous random value in the next (netem's get_crandom)."""

    def __init__(self, percent, correlation=0.0):
        self.bound, self.same, self.last = percent / 100, correlation / 100, random.random()

    def comes(self):
        self.last = (1 - self.same) * random.random() + self.same * self.last
        return self.last < self.bound


class Way:
    """One direction. Both directions share `count`."""

    def __init__(self, words, leaves, count):
        delay = words.get("delay", [0])
        self.delay, self.jitter = delay[0] / 1000, (delay[1] if len(delay) > 1 else 0) / 1000
        self.lost = Chance(*words.get("loss", [0]))
        self.doubled = Chance(*words.get("duplicate", [0]))
        self.reordered = Chance(*words.get("reorder", [0]))
        self.bits_a_second = words.get("rate", [0])[0] * 1000
        self.leaves, self.count = leaves, count
        self.late, self.number, self.newest, self.busy_until = [], 0, 0, 0.0

    def take(self, packet, now):
        if self.lost.comes() or len(self.late) >= ROOM:
            self.count["lost"] += 1
            return
        again = self.doubled.comes()
        self.count["doubled"] += again
        for _ in range(1 + again):
            starts = max(now, self.busy_until)
            if self.bits_a_second:
                starts = self.busy_until = starts + len(packet) * 8 / self.bits_a_second
            due = starts
            if not self.reordered.comes():
                due += max(0.0, self.delay + random.uniform(-self.jitter, self.jitter))
            self.number += 1
            heapq.heappush(self.late, (due, self.number, now, packet))

    def send(self, now):
        while self.late and self.late[0][0] <= now:
            _, which, came, packet = heapq.heappop(self.late)
            try:
                os.write(self.leaves, packet)
            except OSError:
                continue  # the device is not up
            self.count["passed"] += 1
            self.count["overtaken"] += which < self.newest
            self.count["ms"] += 1000 * (now - came)
            self.newest = max(self.newest, which)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    words = words_of(sys.argv[3:])
    random.seed(1)
    one, other = device(sys.argv[1]), device(sys.argv[2])
    count = dict.fromkeys(("passed", "lost", "overtaken", "doubled", "ms"), 0)
    ways = {one: Way(words, other, count), other: Way(words, one, count)}
    ended = []
    signal.signal(signal.SIGTERM, lambda *_: ended.append(True))
    print("ready", flush=True)
    while not ended:
        due = min((way.late[0][0] for way in ways.values() if way.late), default=None)
        patience = 0.05 if due is None else min(0.05, max(0.0, due - time.monotonic()))
        for ready in select.select(list(ways), [], [], patience)[0]:
            try:
                packet = os.read(ready, 65536)
            except OSError:
                continue
            if packet[0] >> 4 == 4:
                ways[ready].take(packet, time.monotonic())
        for way in ways.values():
            way.send(time.monotonic())
    mean = count.pop("ms") / max(1, count["passed"])
    print(" ".join(f"{name} {value}" for name, value in count.items()), f"mean {mean:.0f} ms", flush=True)


if __name__ == "__main__":
    main()
