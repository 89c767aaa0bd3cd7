# shellcheck shell=bash
# free_ports N: N UDP ports in one line that nobody holds. They lie below those that the kernel hands out by itself, so whoever runs beside this
# and takes any port does not take one of these.
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
for probe in held: # Closed before the line is printed: its reader may use the ports while this process is still ending.
    probe.close()
print(*ports)
PYTHON
}
