"""LinuxCNC's screen AXIS itself, under Xvfb: it opens the corrected program, and shows why a
program is refused."""

from __future__ import annotations

import functools
import json
import os
import subprocess
from pathlib import Path

import pytest

from postproc.cli import main
from tests.linuxcnc.headless import OUTER

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gcomp" / "linuxcnc-axis"
# The first unshare is root in its own world, to mount; the second is a common user there, since
# LinuxCNC refuses root. /tmp is empty there, in memory, and shows the test's two folders only: a
# lock of another LinuxCNC and the sockets of other displays lie at fixed places in /tmp.
OVERLAY = " && ".join(
    [
        "mount -t overlay overlay -o lowerdir=usr:/usr /usr",
        "mount -t overlay overlay -o lowerdir=etc:/etc /etc",
        "mount -t tmpfs tmpfs /mnt",
        "mkdir /mnt/project /mnt/place",
        'mount --rbind "$1" /mnt/project',
        'mount --rbind "$2" /mnt/place',
        "mount -t tmpfs -o mode=1777 tmpfs /tmp",
        'mkdir -p "$1" "$2"',
        'mount --rbind /mnt/project "$1"',
        'mount --rbind /mnt/place "$2"',
        "shift 2",
        'exec unshare --user --map-user=1000 --map-group=1000 "$@"',
    ]
)
GOOD = "G21 G90 G54\nG0 X10 Y10 Z-20\nG1 X100 Y80 F600\nM2\n"
BAD = "G21 G90 G54\nG0 X10 Y10 Z-20\nG1 X9000 Y80 F600\nM2\n"
OFFSET = ("--offset", "G54=X0,Y0,Z-100")


def within(place: Path, *command: object) -> list[str]:
    """A command where LinuxCNC and Xvfb lie over /usr and /etc, and which sees the project and
    the folder `place`; to be started in CACHE."""
    return [*OUTER, "sh", "-c", OVERLAY, "sh", str(ROOT), str(place), *map(str, command)]


@functools.cache
def missing() -> str:
    """Why AXIS can not be run; "" where it can."""
    if not (CACHE / "complete").exists():
        return "AXIS is not in the cache: sh tests/hooks/fetch_axis.sh (65 MB)"
    try:
        tried = subprocess.run(
            within(ROOT, "test", "-x", "/usr/bin/axis"), cwd=CACHE, capture_output=True, text=True
        )
    except OSError as error:
        return f"AXIS can not be run in a namespace here: {error}"
    return (
        f"AXIS can not be run in a namespace here: {tried.stderr.strip()[:200]}"
        if tried.returncode
        else ""
    )


@pytest.mark.programs
def test_axis_itself_opens_the_corrected_program_and_shows_a_refusal(tmp_path):
    if missing():
        pytest.skip(missing())
    mill = str(ROOT / "machines" / "example-mill")
    words = [
        "hook",
        "install",
        "linuxcnc",
        "--machine",
        mill,
        "-o",
        str(tmp_path / "hooks"),
        "--",
        *OFFSET,
    ]
    assert main(words) == 0
    script = next((tmp_path / "hooks").iterdir())
    place = tmp_path / "axis"
    place.mkdir()
    (place / "filter.txt").write_text(f"PROGRAM_EXTENSION = .ngc corrected\nngc = {script}\n")
    (place / "good.ngc").write_text(GOOD)
    (place / "bad.ngc").write_text(BAD)
    surroundings = [
        f"HOME={place}",
        "PATH=/usr/bin:/bin",
        "LIBGL_ALWAYS_SOFTWARE=1",
        "LC_ALL=C.UTF-8",
    ]
    host = ["/usr/bin/python3.11", HERE / "axis_host.py", place]
    command = within(tmp_path, "env", "-i", *surroundings, *host)
    done = subprocess.run(command, cwd=CACHE, capture_output=True, text=True, timeout=180)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout.splitlines()[-1])
    assert (
        main(
            [
                str(place / "good.ngc"),
                "--machine",
                mill,
                *OFFSET,
                "-o",
                str(tmp_path / "out"),
                "--quiet",
            ]
        )
        == 0
    )
    expected = (tmp_path / "out").read_text()
    assert "GCOMP" in expected and answer["opened"] == expected
    assert "bad.ngc:3: X = 9000.0000 mm lies outside" in answer["said"]
    assert answer["then"] == expected  # what was loaded stays
