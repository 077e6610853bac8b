# SPDX-License-Identifier: Apache-2.0
"""Where the points of a sweep of accuracy run: `client_of` understands SCHEDULER=.

Empty: this machine, one task at a time, as each uses all processors.  An address, `tcp://...`: a
scheduler of dask that is there.  `slurm`, or `slurm:key=value,...`: jobs of SLURM, by
dask-jobqueue, each of which works on one task at a time; the folder of the project has to be there
under the same path.
"""

import re
from pathlib import Path

from accuracy_costs import AccuracyError

ROOT = Path(__file__).resolve().parents[1]
ADDRESS = re.compile(r"(tcp|tls|ws|wss|ucx)://\S+")
# Keys after `slurm:`, what each must look like, and what it is when it is left out.
KEYS = {
    "jobs": (re.compile(r"[1-9]\d{0,3}"), "1", "a number from 1"),
    "cores": (re.compile(r"[1-9]\d{0,3}"), "2", "a number from 1"),
    "memory": (re.compile(r"[1-9]\d*(\.\d+)?(MB|GB|TB)"), "8GB", "a size, such as 8GB"),
    "walltime": (re.compile(r"(\d+-)?\d{1,2}:\d\d:\d\d"), "04:00:00", "a time, such as 04:00:00"),
    "queue": (re.compile(r"[\w.-]+"), None, "the name of a partition"),
    "account": (re.compile(r"[\w.-]+"), None, "the name of an account"),
    "interface": (re.compile(r"[\w.:-]+"), None, "the name of a network interface"),
}


def slurm_of(text: str) -> dict[str, str | None]:
    """The keys of `slurm:key=value,...` with what was left out; a sentence for what is wrong."""
    found = {key: default for key, (_, default, _) in KEYS.items()}
    for part in filter(None, text.removeprefix("slurm").removeprefix(":").split(",")):
        key, _, value = part.partition("=")
        if key not in KEYS:
            raise AccuracyError(
                f"SCHEDULER={text}: slurm has no key `{key}`; the keys are {', '.join(KEYS)}"
            )
        form, _, what = KEYS[key]
        if not form.fullmatch(value):
            raise AccuracyError(f"SCHEDULER={text}: {key}={value} must be {what}")
        found[key] = value
    return found


def slurm_cluster(keys: dict):
    """The cluster of these keys; no job is submitted before it is scaled."""
    from dask_jobqueue import SLURMCluster

    given = {k: keys[k] for k in ("queue", "account", "interface") if keys[k] is not None}
    return SLURMCluster(
        cores=1,  # of dask: one task at a time, whose threads have all processors of the job
        processes=1,
        job_cpu=int(keys["cores"]),
        memory=keys["memory"],
        walltime=keys["walltime"],
        job_name="ti-accuracy",
        python=str(ROOT / "build/checks/bin/python"),
        **given,
    )


def is_local(scheduler: str) -> bool:
    return not scheduler


def is_slurm(scheduler: str) -> bool:
    return re.match(r"slurm(:|$)", scheduler) is not None


def check(scheduler: str) -> None:
    """Raises `AccuracyError` for a scheduler that is not understood."""
    if is_slurm(scheduler):
        slurm_of(scheduler)
    elif scheduler and not ADDRESS.fullmatch(scheduler):
        raise AccuracyError(
            f"SCHEDULER={scheduler}: give the address of a dask scheduler, tcp://host:port, "
            "or slurm:key=value,..., or nothing for this machine"
        )


def client_of(scheduler: str):
    """A client of dask for a scheduler that `check` has passed."""
    from dask.distributed import Client, LocalCluster

    if is_slurm(scheduler):
        keys = slurm_of(scheduler)
        cluster = slurm_cluster(keys)
        cluster.scale(jobs=int(keys["jobs"]))
        return Client(cluster)
    if scheduler:
        return Client(scheduler)
    return Client(
        LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            processes=False,
            dashboard_address="127.0.0.1:0",  # any port: another sweep may run here
        )
    )
