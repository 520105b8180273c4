"""Many programs, on one or several machines: what is to be done, who does it, what came of it.

`jobs` finds programs and says where each result goes; `work` does one of them, in any process;
`pool` hands jobs to processes of this computer or to a Dask cluster and lives through the end of
any of them; `ledger` remembers what is done, so that a run that was stopped goes on where it was.
The command is postproc/commands/batch.py.
"""
