"""Send a program with grbl-streamer: python peer_grbl_streamer.py PORT FILE. Prints done when its
job is completed, error at an error."""

import logging
import os
import sys
import time

from grbl_streamer import GrblStreamer

port, path = sys.argv[1:]
said = []


def callback(event, *data):
    if event in ("on_boot", "on_job_completed", "on_error", "on_alarm"):
        said.append(event)


logging.disable(logging.CRITICAL)
streamer = GrblStreamer(callback)
streamer.setup_logging()
streamer.cnect(port, 115200)
until = time.monotonic() + 3.0
while "on_boot" not in said and time.monotonic() < until:
    time.sleep(0.02)
time.sleep(0.5)
streamer.poll_start()
streamer.incremental_streaming = False
streamer.load_file(path)
said.clear()
streamer.job_run()
while not {"on_job_completed", "on_error", "on_alarm"} & set(said):
    time.sleep(0.02)
print("done" if "on_job_completed" in said and "on_error" not in said else "error", flush=True)
os._exit(0)
