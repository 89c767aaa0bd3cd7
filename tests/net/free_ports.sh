# shellcheck shell=bash
# free_ports N: prints N free UDP ports in one line. They are below the kernel's range for automatic ports, so another process that lets the kernel
# choose its port does not get one of them.
free_ports() {
    python3 - "$1" <<'PYTHON'
import random
import socket
import sys

held = []
while len(held) < int(sys.argv[1]):
    port, probe = random.randrange(10000, 32768), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        probe.bind(("127.0.0.1", port))
        held.append(probe)
    except OSError:
        pass
ports = [probe.getsockname()[1] for probe in held]
for probe in held: # Closes the sockets before it prints: the reader of the line may use the ports before this process ends.
    probe.close()
print(*ports)
PYTHON
}
