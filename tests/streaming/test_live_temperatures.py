"""`gcomp stream --live-temperatures`: a log that can not be believed any more ends in a hold."""

from __future__ import annotations

import time

from tests.heat.test_heat import machine
from tests.streaming.pty_host import PtyHost
from tests.streaming.stream_process import PATIENCE, model, sent_rows, start

# wide comments, so that little of the program is prepared ahead
PROGRAM = "G21 G90 G94 G54 G17\nG0 X0 Y0\n" + "".join(
    f"G1 X{100 + k % 2} F3000 ({'.' * 2000})\n" for k in range(400)
)


def test_a_log_that_fails_in_the_middle_of_a_job_ends_it_in_a_hold(tmp_path):
    machine(tmp_path)
    record = tmp_path / "log.csv"
    record.write_text("t_s,T_scale_X_C\n0,20\n10,20.1\n")
    (tmp_path / "job.nc").write_text(PROGRAM + "M30\n")
    made = model()
    made.stored["G54"] = [0.0, 0.0, 0.0]
    with PtyHost(made, speed=8.0) as host:
        process = start(
            tmp_path,
            host,
            "--temperatures",
            "log.csv",
            "--live-temperatures",
            "job.nc",
            machine=("--machine", str(tmp_path / "warm"), "--dialect", "grbl"),
        )
        deadline = time.monotonic() + PATIENCE
        while len(sent_rows(host)) < 8 and time.monotonic() < deadline and process.poll() is None:
            time.sleep(0.005)
        with open(record, "a") as file:
            file.write("40,85\n")
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode not in (0, None) and "Traceback" not in err, err
        assert "no line can be prepared any more: " in err
        assert "log.csv:4: T_scale_X_C goes from 20.1 to 85 C in 30 s" in err
        assert host.soon(lambda: host.model.state.startswith("Hold")), host.model.state
        assert 8 <= len(sent_rows(host)) < 350
