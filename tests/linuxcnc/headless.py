"""LinuxCNC, whole and without a display, as a receiver of programs: what its joints did, in mm and
machine coordinates.

Fetched by fetch_headless.sh. It runs in namespaces of its own (users, mounts, processes, network,
shared memory): the fetched tree is laid over /usr there, because LinuxCNC looks for its modules at
fixed places, and nothing of it is seen or left behind outside. It is no real-time machine: the
servo period is kept as well as the system allows, and what is asserted must not depend on it.
"""

import functools
import json
import os
import queue
import subprocess
import tempfile
import threading
from pathlib import Path

HERE = Path(__file__).parent
CACHE = (
    Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gcomp" / "linuxcnc-headless"
)
# The first unshare is root in its own world, to mount; the second is a common user there, since
# LinuxCNC refuses root.
OUTER = [
    "unshare",
    "--user",
    "--map-root-user",
    "--mount",
    "--ipc",
    "--net",
    "--pid",
    "--fork",
    "--kill-child",
    "--mount-proc",
]
OVERLAY = (
    "mount -t overlay overlay -o lowerdir=usr:/usr /usr && cd / && exec unshare --user"
    ' --map-user=1000 --map-group=1000 "$@"'
)
ANSWER = 120.0  # s


class Refused(Exception):
    """LinuxCNC refuses a line, or does not do what it was told; in its words."""


def within(*command):
    """`command`, run where LinuxCNC lies over /usr; to be started in CACHE."""
    return [*OUTER, "sh", "-c", OVERLAY, "sh", *map(str, command)]


@functools.cache
def available():
    """None if LinuxCNC can be run, else why not (for pytest.skip). Fetches nothing by itself."""
    if not (CACHE / "complete").exists():
        return "LinuxCNC is not in the cache: sh tests/linuxcnc/fetch_headless.sh (22 MB)"
    try:
        tried = subprocess.run(
            within("test", "-x", "/usr/bin/milltask"),
            cwd=CACHE,
            capture_output=True,
            text=True,
            timeout=30,
        )
    except (OSError, subprocess.SubprocessError) as error:
        return f"LinuxCNC can not be run in a namespace here: {error}"
    if tried.returncode:
        return f"LinuxCNC can not be run in a namespace here: {tried.stderr.strip()[:200]}"
    return None


class Controller:
    """A running LinuxCNC, for `with`; homed at machine zero.

    parameters: {5223: -250.0, ...} as LinuxCNC keeps them, mm; tools: {number: length in mm}.
    """

    def __init__(self, parameters=None, tools=None):
        self.settings = {"parameters": parameters or {}, "tools": tools or {}}

    def __enter__(self):
        # short: a socket's path has 107 characters
        self.folder = tempfile.TemporaryDirectory(prefix="gcomp-")
        self.process = subprocess.Popen(
            within(
                "/usr/bin/python3.11",
                HERE / "headless_host.py",
                self.folder.name,
                json.dumps(self.settings),
            ),
            cwd=CACHE,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={
                "HOME": self.folder.name,
                "PATH": "/usr/bin:/bin:/usr/sbin:/sbin",
                "LC_ALL": "C.UTF-8",
                "PYTHONDONTWRITEBYTECODE": "1",
            },
        )
        self.answers = queue.Queue()
        threading.Thread(target=self._listen, daemon=True).start()
        try:
            self.version = self._answer()["ready"]
        except Exception:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.folder.cleanup()

    def _listen(self):
        for line in self.process.stdout:
            self.answers.put(json.loads(line))
        self.answers.put({"trouble": f"LinuxCNC ended: {self._log()}"})

    def _log(self):
        log = Path(self.folder.name) / "log"
        return log.read_text()[-500:] if log.exists() else "nothing was logged"

    def _answer(self):
        answer = self.answers.get(timeout=ANSWER)
        if "trouble" in answer:
            raise Refused(answer["trouble"])
        return answer

    def _ask(self, **request):
        print(json.dumps(request), file=self.process.stdin, flush=True)
        return self._answer()

    def run(self, text):
        """Auto mode, with M0 behind motions: ([(line of the motion, (3,) mm)] at each M0, (3,) mm
        at the end)."""
        answer = self._ask(program=text)
        return [(line, tuple(joints)) for line, joints in answer["stops"]], tuple(answer["end"])

    def mdi(self, lines):
        """One line after the other in MDI mode: [(3,) mm] behind each."""
        return [tuple(joints) for joints in self._ask(mdi=list(lines))["reached"]]
