"""A Slurm of two nodes on this machine, started and ended by the tests that use it."""

import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path

NEEDED = ("slurmctld", "slurmd", "munged", "sbatch", "squeue", "scontrol", "runuser")
PATH = f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"
LACKS = [name for name in NEEDED if shutil.which(name, path=PATH) is None]
NO_SLURM = (
    f"Slurm is not installed ({', '.join(LACKS)}): apt-get install slurm-wlm munge"
    if LACKS
    else "Slurm's daemons are started by root alone"
    if os.geteuid() != 0
    else ""
)
"""Why there can be none; empty if there can."""
NODES = ("n1", "n2")

CONF = """ClusterName=sunfleck
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={munge}
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd-%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
ReturnToService=2
MpiDefault=none
KillWait=2
SlurmdTimeout=6
SchedulerParameters=sched_interval=1,bf_interval=1,sched_min_interval=0,requeue_delay=0
NodeName=n[1-2] NodeHostname={host} NodeAddr=127.0.0.1 Port=[{first}-{second}] CPUs=1 RealMemory=16000
PartitionName=all Nodes=n[1-2] Default=YES MaxTime=INFINITE State=UP
"""


class Slurm:
    """The daemons of one, and a key of its own."""

    def __init__(self) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="slurm", dir="/tmp"))
        self.daemons: dict[str, subprocess.Popen] = {}
        ports = _free_ports(3)
        host = socket.gethostname().partition(".")[0]
        (self.folder / "state").mkdir()
        (self.folder / "slurm.conf").write_text(
            CONF.format(
                host=host, folder=self.folder, munge=self.folder / "munge/socket",
                port=ports[0], first=ports[1], second=ports[2],
            )  # fmt: skip
        )
        self.environment = {**os.environ, "PATH": PATH, "SLURM_CONF": str(self.folder / "slurm.conf")}

    def start(self) -> None:
        """Raises `RuntimeError` with what the daemons said if they do not come up."""
        self._munge()
        self._daemon("slurmctld", "slurmctld", "-D")
        for node in NODES:
            self.start_node(node)
        self.wait_for(lambda: self.told("sinfo", "-h", "-o", "%t %D").split() == ["idle", "2"], 60)

    def _munge(self) -> None:
        """Munge trusts no folder that others may write to, and wants a user of its own."""
        os.chmod(self.folder, 0o755)
        folder = self.folder / "munge"
        folder.mkdir(mode=0o755)
        key = folder / "key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        for path in (key, folder):
            shutil.chown(path, "munge", "munge")
        named = {"key-file": key, "socket": folder / "socket", "pid-file": folder / "pid",
                 "log-file": folder / "log", "seed-file": folder / "seed"}  # fmt: skip
        # /tmp may be written to by all, which it forgives when told to.
        self._daemon("munged", "runuser", "-u", "munge", "--", shutil.which("munged", path=PATH), "--foreground",
                     "--force", *(f"--{name}={path}" for name, path in named.items()))  # fmt: skip
        self.wait_for((folder / "socket").exists, 20)

    def start_node(self, node: str) -> None:
        """Has a node come up, or come back."""
        self._daemon(node, "slurmd", "-D", "-N", node)

    def kill_node(self, node: str) -> None:
        """As a machine that loses its power: the daemon and all that it runs are gone."""
        stepds = self._of_node(node)
        self.daemons.pop(node).kill()
        for pid in stepds:
            for each in [*_below(pid), pid]:
                _kill(each)

    def _of_node(self, node: str) -> list[int]:
        """Of each task that runs on a node the process that watches it."""
        jobs = self.told("squeue", "-h", "-w", node, "-t", "running", "-o", "%A").split()
        found = []
        for pid, words in _processes().items():
            if words and words[0].startswith("slurmstepd:") and any(f"[{job}." in words[0] for job in jobs):
                found.append(pid)
        return found

    def _daemon(self, name: str, *words: str) -> None:
        with open(self.folder / f"{name}.said", "ab") as said:
            self.daemons[name] = subprocess.Popen(
                words, env=self.environment, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True
            )

    def told(self, *words: str) -> str:
        """What a command of Slurm prints."""
        return subprocess.run(words, env=self.environment, capture_output=True, text=True).stdout

    def states(self) -> str:
        """Of all tasks there are, running or waiting."""
        return self.told("squeue", "-h", "-r", "-o", "%i %j %t %r")

    def hurry(self) -> None:
        """Has tasks start that Slurm put back in the queue: it makes them wait for two minutes."""
        for line in self.told("squeue", "-h", "-r", "-t", "pending", "-o", "%i %r").splitlines():
            job, _, reason = line.partition(" ")
            if reason == "BeginTime":
                self.told("scontrol", "update", f"JobId={job}", "StartTime=now")

    def wait_until_down(self, node: str) -> None:
        """Until Slurm has noticed that a node is gone."""
        self.wait_for(lambda: "down" in self.told("sinfo", "-h", "-n", node, "-o", "%t"), 90)

    def wait_for(self, is_so, seconds: float) -> None:
        """Waits until something is so."""
        deadline = time.monotonic() + seconds
        while not is_so():
            if time.monotonic() > deadline:
                raise RuntimeError(f"not within {seconds} s\n{self.states()}\n{self.said()}")
            time.sleep(0.1)

    def said(self) -> str:
        """The ends of all logs."""
        logs = sorted([*self.folder.glob("*.log"), *self.folder.glob("*.said")])
        return "\n".join(f"{log.name}:\n{log.read_text(errors='replace')[-1500:]}" for log in logs)

    def stop(self) -> None:
        """Ends all of it."""
        self.told("scancel", "--user", "root")
        for name in reversed(list(self.daemons)):
            daemon = self.daemons[name]
            daemon.send_signal(signal.SIGTERM)
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def _free_ports(count: int) -> list[int]:
    """Ports in a row that nobody listens at."""
    for first in range(26817, 60000, 10):
        try:
            for port in range(first, first + count):
                with socket.socket() as probe:
                    probe.bind(("127.0.0.1", port))
        except OSError:
            continue
        return list(range(first, first + count))
    raise RuntimeError("there are no free ports")


def _processes() -> dict[int, list[str]]:
    found = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            found[int(entry.name)] = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
    return found


def _below(pid: int) -> list[int]:
    """Processes that a process started, and those that they did."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(entry.read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
        if parent == pid:
            child = int(entry.parent.name)
            found += [*_below(child), child]
    return found


def _kill(pid: int) -> None:
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
