#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs docs/slurm.sh under a Slurm of its own on this machine: a job whose time ends, its requeue until the set is complete,
and the complete set submitted again. The set must have the bytes of one that was never interrupted.

Usage: slurm_job.py TACTEL SLURM.sh
Ends with 77 (skipped) where Slurm or munge are not installed. Takes some minutes: Slurm's shortest time is a minute."""
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time

PROGRAMS = ["munged", "slurmctld", "slurmd", "sbatch", "srun", "scontrol", "sinfo"]
PATH = os.environ["PATH"] + ":/usr/sbin:/sbin"
# Chunks of a few seconds with few rows: a set of minutes that is not large.
SWEEP = """[sweep]
contacts = CONTACTS
seed = 5
[sensor]
columns = 161
rows = 25
[contact]
friction = { uniform = [0.2, 1.0] }
[indenter]
shape = "parabola"
radius = { log_uniform = [2, 50] }
[load]
indentation = { uniform = [0.05, 0.2] }
tangential_step = 0.1
tangential_steps = 2
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Slurm:
    """munged, slurmctld and slurmd of this user in a folder, with this machine as their only node."""

    def __init__(self, folder):
        self.folder, self.processes = folder, []
        self.environment = {**os.environ, "PATH": PATH, "SLURM_CONF": str(folder / "slurm.conf"),
                            "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        for name in ("state", "spool", "munge"):
            (folder / name).mkdir(mode=0o700)
        key = folder / "munge" / "key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        user, host = subprocess.check_output(["id", "-un"], text=True).strip(), socket.gethostname().split(".")[0]
        (folder / "slurm.conf").write_text(f"""ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=10
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
KillWait=20
ReturnToService=2
SchedulerParameters=batch_sched_delay=0
NodeName={host} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
""")
        self.start("munged", "--foreground", f"--key-file={key}", f"--socket={folder}/munge/socket", "--force",
                   f"--pid-file={folder}/munge/pid", f"--log-file={folder}/munge/log", f"--seed-file={folder}/munge/seed")
        self.start("slurmctld", "-D", "-c")
        self.start("slurmd", "-D", "-N", host)
        self.until(60, "its node is idle", lambda: self.say("sinfo", "-h", "-o", "%T").strip() == "idle")

    def start(self, *command):
        log = open(self.folder / f"{command[0]}.log", "w")
        self.processes.append(subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, env=self.environment))

    def say(self, *command):
        return subprocess.run(command, capture_output=True, text=True, env=self.environment).stdout

    def until(self, seconds, what, holds):
        end = time.time() + seconds
        while not holds():
            if time.time() > end:
                raise AssertionError(f"not within {seconds} s: {what}")
            time.sleep(0.5)

    def submit(self, *arguments):
        """Runs a job to its last end. Returns {"JobState": ..., "Restarts": ...}."""
        submitted = subprocess.run(["sbatch", "--parsable", *arguments], capture_output=True, text=True, env=self.environment)
        if submitted.returncode != 0:
            raise AssertionError(submitted.stderr)
        job = submitted.stdout.strip()
        found = {}

        def ended():
            found.update(entry.split("=", 1) for entry in self.say("scontrol", "show", "job", job).split() if "=" in entry)
            return found.get("JobState") in ("COMPLETED", "FAILED", "TIMEOUT", "CANCELLED", "NODE_FAIL")

        self.until(1500, f"job {job} ends", ended)
        return found

    def close(self):
        for process in reversed(self.processes):
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()


def expect(good, problem):
    if not good:
        raise AssertionError(problem)


def check(tactel, script, folder):
    # As many contacts as take three minutes, by the pace of a chunk: a job of a minute ends before.
    sweep, probe = folder / "sweep.toml", folder / "probe.toml"
    probe.write_text(SWEEP.replace("CONTACTS", "8192"))
    subprocess.run([tactel, "generate", probe, "--output", folder / "warm.h5", "--quiet"], check=True)
    begin = time.time()
    subprocess.run([tactel, "generate", probe, "--output", folder / "probe.h5", "--quiet"], check=True)
    chunks = max(4, round(180 / (time.time() - begin)))
    sweep.write_text(SWEEP.replace("CONTACTS", str(8192 * chunks)))
    whole, output, log = folder / "whole.h5", folder / "set.h5", folder / "job.out"
    subprocess.run([tactel, "generate", sweep, "--output", whole, "--quiet"], check=True)

    work = folder / "work"  # the script calls build/tactel
    (work / "build").mkdir(parents=True)
    (work / "build" / "tactel").symlink_to(tactel)
    slurm = Slurm(folder)
    try:
        # Two tasks of one core on the only node; Slurm looks at the time each half minute: SIGINT comes after 15 to 45 s.
        job = ["--nodes=1", "--ntasks-per-node=2", "--cpus-per-task=1", "--time=1", "--signal=INT@45", f"--chdir={work}",
               f"--output={log}", script, sweep, output]
        ended = slurm.submit(*map(str, job))
        said = log.read_text()
        expect(ended["JobState"] == "COMPLETED", f"the job ended as {ended['JobState']}:\n{said}")
        expect(int(ended["Restarts"]) >= 1, f"the job's time never ended:\n{said}")
        expect("stopped; complete chunks are kept" in said, f"tactel did not say that it stopped:\n{said}")
        expect(output.read_bytes() == whole.read_bytes(), "the set has other bytes than one of a single run")
        again = slurm.submit(*map(str, job))
        expect(again["JobState"] == "COMPLETED" and again["Restarts"] == "0", f"submitted again: {again['JobState']}")
        expect(log.read_text()[len(said):].count("complete already") == 1, log.read_text()[len(said):])
        expect(output.read_bytes() == whole.read_bytes(), "the complete set changed")
        print(f"{chunks} chunks, {ended['Restarts']} requeues, the same {whole.stat().st_size} bytes")
    except AssertionError:
        for name in ("slurmctld", "slurmd", "munged"):
            print(f"--- {name}\n" + (folder / f"{name}.log").read_text()[-3000:])
        raise
    finally:
        slurm.close()


def main(tactel, script):
    absent = [program for program in PROGRAMS if not shutil.which(program, path=PATH)]
    if absent:
        print(f"skipped: {', '.join(absent)} not found; apt-get install slurmctld slurmd slurm-client munge")
        return 77
    folder = pathlib.Path(tempfile.mkdtemp(prefix="tactel-slurm-"))
    try:
        check(os.path.abspath(tactel), os.path.abspath(script), folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return 0


if __name__ == "__main__":
    os.environ["PATH"] = PATH
    sys.exit(main(*sys.argv[1:]))
