"""Runs a program that may not end, with a limit that does not depend on the other load of the machine."""
import os
import signal
import subprocess

# A program that waits for ever uses no processor time. run_limited() stops it after this many times the limit, in wall-clock time.
CLOCK_FACTOR = 8


def run_limited(command, seconds, **options):
    """Runs a command that may use `seconds` of every processor. Returns (status, stdout, stderr). Status None: the limit stopped it.

    The limit is processor time, because under other load a program gets only a share of the processors."""
    limited = ["bash", "-c", f'ulimit -S -t {seconds * (os.cpu_count() or 1)}; exec "$@"', "limit", *map(str, command)]
    try:
        done = subprocess.run(limited, capture_output=True, text=True, errors="replace", timeout=CLOCK_FACTOR * seconds, **options)
    except subprocess.TimeoutExpired as late:
        return None, (late.stdout or b"").decode(errors="replace"), (late.stderr or b"").decode(errors="replace")
    is_stopped = done.returncode == -signal.SIGXCPU
    return (None if is_stopped else done.returncode), done.stdout, done.stderr
