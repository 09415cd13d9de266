"""The command line as a process of its own."""

import contextlib
import os
import signal
import subprocess
import sys
import time

import pytest

HYDROSERVO = (sys.executable, "-c", "from hydroservo.cli import main; main()")
needs_posix = pytest.mark.skipif(os.name != "posix", reason="POSIX signals and devices")


def process(*args, **options):
    return subprocess.run(
        [*HYDROSERVO, *args], text=True, capture_output=not options, check=False, timeout=120, **options
    )


def interrupted(*args, number=signal.SIGINT, **options):
    """The command, interrupted after two seconds."""
    running = subprocess.Popen(
        [*HYDROSERVO, *args], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options
    )
    with running:
        time.sleep(2.0)
        running.send_signal(number)
        try:
            stdout, stderr = running.communicate(timeout=60)
        finally:
            running.kill()
    return running.returncode, stdout, stderr


def leaves_nothing(out, *args):
    """A command that writes to a folder, interrupted as it computes: one line, and no folder."""
    status, stdout, stderr = interrupted(*args)
    assert status == 130
    assert stdout == ""
    assert stderr == "hydroservo: interrupted; nothing was left half-written\n"
    assert not out.exists()


def ends_by(number, word, folder, *args):
    """A command that computes ends by a signal: one line, its status, and no file in the temporary folder."""
    environment = {**os.environ, "TMPDIR": str(folder)}
    status, stdout, stderr = interrupted(*args, number=number, env=environment)
    assert (status, stdout) == (128 + number, "")
    assert stderr == f"hydroservo: {word}; nothing was left half-written\n"
    assert list(folder.iterdir()) == []


def on_terminal(stream, *args):
    """The exit status, what one stream shows on a terminal, and what the other stream says."""
    import pty

    master, slave = pty.openpty()
    code = "from hydroservo.cli import main, messages; messages.PATIENCE = 0.0; main()"
    environment = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "60"}
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | {stream: slave}
    running = subprocess.Popen([sys.executable, "-c", code, *args], env=environment, text=True, **streams)
    os.close(slave)
    shown = bytearray()
    with contextlib.suppress(OSError):  # Linux ends a terminal that all have left so
        while chunk := os.read(master, 4096):
            shown += chunk
    os.close(master)
    said = running.communicate(timeout=60)
    return running.returncode, shown.decode().replace("\r\n", "\n"), "".join(filter(None, said))


def heavy_libraries_of(module):
    """Which libraries that take long to import a module has loaded; rich may be typer's."""
    heavy = "{'matplotlib', 'xarray', 'pandas', 'numba', 'scipy', 'pint'}"
    code = f"import sys, {module}; print(*sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([HYDROSERVO[0], "-c", code], text=True, capture_output=True, check=True)
    return done.stdout.split()
