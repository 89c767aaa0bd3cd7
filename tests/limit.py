"""Runs a program that may not end, with a limit that does not depend on what else the machine does."""
import os
import signal
import subprocess

# A program that waits for ever uses no processor: this many times the limit, by the clock, ends it too.
CLOCK_FACTOR = 8


def run_limited(command, seconds, **options):
    """(status or None, stdout, stderr) of a command that may use `seconds` of every processor. None: it was stopped at the limit.

    The limit is time of processors, because beside other load a program gets a share of them only."""
    limited = ["bash", "-c", f'ulimit -S -t {seconds * (os.cpu_count() or 1)}; exec "$@"', "limit", *map(str, command)]
    try:
        done = subprocess.run(limited, capture_output=True, text=True, errors="replace", timeout=CLOCK_FACTOR * seconds, **options)
    except subprocess.TimeoutExpired as late:
        return None, (late.stdout or b"").decode(errors="replace"), (late.stderr or b"").decode(errors="replace")
    is_stopped = done.returncode == -signal.SIGXCPU
    return (None if is_stopped else done.returncode), done.stdout, done.stderr
